"""What Hydra discovers of foundry: model tags and named sweeps as configs, seed ranges, the launcher."""
