"""Sections: a plane or curtain that cuts a model, and features projected onto it."""
