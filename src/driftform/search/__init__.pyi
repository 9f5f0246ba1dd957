from .advance import Observer as Observer
from .executors import open_executor as open_executor
from .jobs import Executor as Executor
from .strategies import PipeGrid as PipeGrid
