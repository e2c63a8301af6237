"""The rules that every world, model, prompt, edit and signature must obey (`foundry check`)."""
