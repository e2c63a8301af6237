"""What the shipped worlds declare of their records, for runs that tests make up."""

from foundry.declared import Actions, Declared, keys_of
from foundry.records import Agent, CameraEpisode, CameraStep, GridStep, Message, SeenImage

MOVES = Actions(labels=("stay", "up", "down", "left", "right"), idle="stay")
GRID = Declared(form="grid", actions={"action": MOVES}, streams=keys_of((GridStep, Message, Agent)))
CAMERA = Declared(form="camera", streams=keys_of((CameraStep, CameraEpisode, SeenImage)))
