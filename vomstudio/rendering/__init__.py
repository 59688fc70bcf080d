"""The only package that sees VTK; its room `qt` alone sees both Qt and VTK."""
