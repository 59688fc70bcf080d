"""Registration of models in World: observations, adjustment, residuals, errors and warnings."""
