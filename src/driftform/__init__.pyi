from .api import Run as Run
from .api import evolve as evolve
from .api import load_study as load_study
from .api import open_agent as open_agent
from .api import open_run as open_run
from .design.design import Design as Design
from .pipeline import Pipeline as Pipeline
from .plugins.discovery import hookimpl as hookimpl
from .runs.agent_file import StoredAgent as StoredAgent
from .study.study import Study as Study

__version__: str
