# Sets foundry up on Windows: powershell -ExecutionPolicy Bypass -File setup.ps1, then .venv\Scripts\foundry
$ErrorActionPreference = "Stop"
Set-Location $PSScriptRoot
python tasks.py setup
if ($LASTEXITCODE -ne 0) { exit $LASTEXITCODE }
Write-Output "Ready: .venv\Scripts\foundry -m model=scripted/random,scripted/avoid seed=0-4"
