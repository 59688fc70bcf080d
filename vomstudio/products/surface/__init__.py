"""A patch as a surface: how it departs from its plane."""
