"""What ships with the core, through the same hooks as any plugin."""
