"""Pictures and sheets made from measurements."""
