"""Registration of a model by another, registered model."""
