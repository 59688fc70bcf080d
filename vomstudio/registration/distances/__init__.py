"""How far a model is from another cloud or mesh."""
