"""How a surface departs from its plane."""
