"""The plug-ins of foundry that Hydra discovers: model tags and named sweeps as configs, seed ranges, the launcher."""
