"""Models placed in World: what is given for it, and the registration that follows."""
