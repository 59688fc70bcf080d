"""Registration of models in World: observations, adjustment, errors and warnings."""
