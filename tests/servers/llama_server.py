"""Serves a model with llama.cpp's own server, which the package xllamacpp carries ready built.

    python llama_server.py FILE PORT [--slots 4] [--context 4096] [--threads 1] [--batch 512] [--cache F16]
        [--remembered 8192]

The model is called `tiny`. Each slot has this context; the key-value cache is of this type; so many MiB of prompts are
remembered beside the slots. Needs xllamacpp alone.
"""

import argparse
import sys
import time

import xllamacpp


def parameters(asked: argparse.Namespace) -> xllamacpp.CommonParams:
    settings = xllamacpp.CommonParams()
    settings.model.path = asked.file
    settings.model_alias = {"tiny"} if isinstance(settings.model_alias, set) else "tiny"
    if hasattr(settings, "hostnames"):
        settings.hostnames = ["127.0.0.1"]
    else:  # as versions before the autumn of 2026 call it
        settings.hostname = "127.0.0.1"
    settings.port = asked.port
    settings.n_parallel, settings.n_ctx, settings.n_batch = asked.slots, asked.slots * asked.context, asked.batch
    for threads in (settings.cpuparams, settings.cpuparams_batch):
        threads.n_threads = asked.threads
    kind = getattr(xllamacpp.ggml_type, f"GGML_TYPE_{asked.cache}")
    settings.cache_type_k = settings.cache_type_v = kind
    settings.cache_ram_mib = asked.remembered
    settings.endpoint_metrics = True
    return settings


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file")
    parser.add_argument("port", type=int)
    for name, number in (("slots", 4), ("context", 4096), ("threads", 1), ("batch", 512), ("remembered", 8192)):
        parser.add_argument(f"--{name}", type=int, default=number)
    parser.add_argument("--cache", default="F16")
    server = xllamacpp.Server(parameters(parser.parse_args()))
    sys.stdout.write(f"{server.listening_address}\n")
    while True:
        time.sleep(3600)


if __name__ == "__main__":
    main()
