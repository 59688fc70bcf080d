"""The stages one after the other, resumed where they stopped, and what is told of them."""
