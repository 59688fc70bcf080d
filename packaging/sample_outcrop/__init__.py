"""The sample outcrop: a cliff whose geology is known exactly because it was made.

Nothing in here imports the program. What it measures can therefore be judged by this truth.
"""
