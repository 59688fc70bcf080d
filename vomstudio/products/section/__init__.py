"""Sections: where a plane or a curtain cuts a model, and what is projected onto it."""
