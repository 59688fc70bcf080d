"""Scale-true pictures along a direction."""
