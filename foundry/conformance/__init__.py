"""The rules of `foundry check`, which every world, model, prompt, edit and signature must pass."""
