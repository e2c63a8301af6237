#!/usr/bin/env sh
# Sets foundry up on macOS and Linux: ./setup.sh, then .venv/bin/foundry
set -eu
cd "$(dirname "$0")"
"${PYTHON:-python3}" tasks.py setup
echo "Ready: .venv/bin/foundry -m model=scripted/random,scripted/avoid seed=0-4"
