"""A real browser, and the page of a run in it."""

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from driftform.cli.report import report
from driftform.runs.directory import DATABASE
from driftform.runs.store import Store
from driftform.search.in_process import InProcess
from driftform.search.loop import run_search
from driftform.study import load_study


@pytest.fixture(scope="session")
def run_with_page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of twenty flights for ten targets, with its page."""
    directory = tmp_path_factory.mktemp("runs") / "run"
    directory.mkdir()
    study = load_study(
        "paper", use={"simulator": "native", "strategy": "random"}, run={"seed": 4, "evaluations": 20}
    )
    with Store.create(directory / DATABASE, dict(study.document)) as store:
        run_search(study, store, InProcess(study.make_pipeline()))
    report(directory)
    return directory


@pytest.fixture(scope="session")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """Headless Chromium without a network."""
    for program in ("chromium", "chromedriver"):
        if shutil.which(program) is None:
            pytest.skip(f"{program} is not installed")
    from selenium import webdriver

    options = webdriver.ChromeOptions()
    options.binary_location = str(shutil.which("chromium"))
    for argument in (
        *("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--hide-scrollbars"),
        *("--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-background-networking"),
        *("--disable-component-update", "--disable-sync", "--no-first-run", "--disable-quic"),
        f"--user-data-dir={tmp_path_factory.mktemp('profile')}",
    ):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    service = webdriver.ChromeService(executable_path=shutil.which("chromedriver"))
    driver = webdriver.Chrome(options=options, service=service)
    driver.execute_cdp_cmd("Network.enable", {})
    driver.execute_cdp_cmd(
        "Network.emulateNetworkConditions",
        {"offline": True, "latency": 0, "downloadThroughput": 0, "uploadThroughput": 0},
    )
    yield driver
    driver.quit()
