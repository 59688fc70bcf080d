"""The only package that sees VTK; `viewport` alone sees both Qt and VTK."""
