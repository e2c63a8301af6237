"""What the shipped worlds declare of their records, for runs that tests make up."""

from foundry.declared import Declared, keys_of
from foundry.records import Agent, CameraEpisode, CameraStep, GridStep, Message, SeenImage

GRID = Declared(form="grid", streams=keys_of((GridStep, Message, Agent)))
CAMERA = Declared(form="camera", streams=keys_of((CameraStep, CameraEpisode, SeenImage)))
