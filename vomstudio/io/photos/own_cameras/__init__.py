"""The cameras of a model as other programs write them, one module a program."""
