from .advance import Observer as Observer
from .coverage import PipeGrid as PipeGrid
from .executors import open_executor as open_executor
from .pool import Executor as Executor
