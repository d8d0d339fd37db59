"""config/ is found from wherever the package runs."""

import pytest

from test.packaging.imports import ROOT
from trunk_ros.errors import TrunkError
from trunk_ros.share import config_names, config_path, share_folder


def test_a_checkout_uses_its_own_config():
    assert share_folder() == ROOT
    assert config_path("trunk") == config_path("trunk.yaml") == ROOT / "config/trunk.yaml"


# of colcon and pip, of apt, of pip --target
LIBRARIES = ["lib/python3.12/site-packages", "lib/python3/dist-packages", "."]


@pytest.mark.parametrize("library", LIBRARIES)
def test_an_install_uses_the_share_folder_of_its_prefix(tmp_path, library):
    (tmp_path / "share/trunk_ros/config").mkdir(parents=True)
    (tmp_path / "share/trunk_ros/package.xml").touch()
    assert share_folder(tmp_path / library / "trunk_ros/share.py") == tmp_path / "share/trunk_ros"


def test_a_package_without_its_files_says_so(tmp_path):
    with pytest.raises(TrunkError, match="install trunk_ros again"):
        share_folder(tmp_path / "trunk_ros/share.py")


def test_a_wrong_name_is_answered_with_the_right_ones():
    assert {"trunk", "direct"} <= set(config_names())
    with pytest.raises(TrunkError, match=r"'trnk'.*direct.*trunk") as caught:
        config_path("trnk")
    assert "\n" not in str(caught.value)
