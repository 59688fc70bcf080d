"""What a model made of photos rests on."""
