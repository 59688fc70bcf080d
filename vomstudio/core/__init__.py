"""What every other package may use: findings and their texts."""
