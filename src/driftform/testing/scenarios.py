"""Contract of scenarios: the package of TOML files that a plugin names by the hook ``driftform_scenarios``."""

from importlib import resources

from driftform.study import load_study
from driftform.study.sources import read_scenarios
from driftform.testing.contract import Contract


class ScenariosContract(Contract):
    """Inherit this class, and return what the hook returns; the plugin must be installed::

    class TestMyScenarios(ScenariosContract):
        def package(self) -> str:
            return driftform_scenarios()
    """

    def package(self) -> str:
        """Return the name of the package with the scenario files."""
        raise NotImplementedError

    def files(self) -> dict[str, str]:
        """Return the text of each scenario file by its name."""
        folder = resources.files(self.package())
        return {
            entry.name.removesuffix(".toml"): entry.read_text(encoding="utf-8")
            for entry in folder.iterdir()
            if entry.name.endswith(".toml")
        }

    def test_each_file_is_a_scenario_of_that_name(self) -> None:
        """The package has at least one TOML file, and no other plugin and no scenario of driftform has its name."""
        assert self.files()
        found = read_scenarios()
        for name, text in self.files().items():
            assert found.get(name) == text, f"'{name}' is that of another distribution, or not installed"

    def test_each_is_a_sound_study_with_a_title(self) -> None:
        """A scenario can be loaded with all its plugins, and says in one line what it is."""
        for name in self.files():
            study = load_study(name, run={"seed": 0})
            assert str(study.document.get("title", "")).strip(), name
            study.make_pipeline()
