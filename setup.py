"""Build description: a stock ament_python package, for colcon and for pip."""

import re
import xml.etree.ElementTree as ET
from pathlib import Path

from setuptools import find_packages, setup

NAME = "spacecraft_gnc"
HERE = Path(__file__).parent
MANIFEST = ET.parse(HERE / "package.xml").getroot()  # noqa: S314 - our own file
CONFIG = [f"config/{path.name}" for path in sorted(HERE.glob("config/*.*"))]
URLS = {url.get("type"): url.text for url in MANIFEST.findall("url")}
CAMPAIGNS = [f"config/campaigns/{path.name}" for path in sorted(HERE.glob("config/campaigns/*"))]
EXTRAS = {
    "campaign": ["distributed>=2024.8", "pyarrow>=15"],  # gnc campaign
    "export": ["pyarrow>=15"],  # gnc export --format parquet
    "reference": ["casadi>=3.6"],  # solver: ipopt of method underactuated
    "view": ["foxglove-sdk>=0.16"],  # gnc view for the Foxglove app
    "ros": [
        "ros-jazzy-rclpy[fastrtps]>=7.1.2",  # first release with working lifecycle transitions
        "ros-jazzy-action-msgs",
        "ros-jazzy-diagnostic-msgs",
        "ros-jazzy-geometry-msgs",
        "ros-jazzy-lifecycle-msgs",
        "ros-jazzy-rosgraph-msgs",
        "ros-jazzy-std-msgs",
        "ros-jazzy-visualization-msgs",
    ],
}


def readme() -> str:
    """Return README.md with its links into the repository made absolute, as an index needs them."""
    text = (HERE / "README.md").read_text(encoding="utf-8")
    place = rf"\g<1>{URLS['repository']}/raw/main/"
    return re.sub(r"""(\]\(|src=")(?![a-z]+:|#)""", place, text)


setup(
    name=NAME,
    version=MANIFEST.findtext("version"),
    description=MANIFEST.findtext("description"),
    maintainer=MANIFEST.findtext("maintainer"),
    maintainer_email=MANIFEST.find("maintainer").get("email"),
    license="Apache-2.0",
    long_description=readme(),
    long_description_content_type="text/markdown",
    url=URLS["website"],
    project_urls={
        "Source": URLS["repository"],
        "Issues": URLS["bugtracker"],
        "Changelog": f"{URLS['repository']}/blob/main/CHANGELOG.md",
    },
    keywords=[
        "spacecraft",
        "attitude control",
        "NMPC",
        "SO(3)",
        "reference governor",
        "ROS 2",
        "MCAP",
    ],
    classifiers=[
        "Development Status :: 4 - Beta",
        "Environment :: Console",
        "Intended Audience :: Science/Research",
        "Operating System :: POSIX :: Linux",
        "Programming Language :: Python :: 3",
        *(f"Programming Language :: Python :: 3.{minor}" for minor in range(10, 15)),
        "Topic :: Scientific/Engineering",
        "Typing :: Typed",
    ],
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    package_data={
        NAME: ["py.typed"],
        f"{NAME}.analysis.live": ["page/*"],
        f"{NAME}.analysis.report": ["*.css", "*.html", "*.js"],
        f"{NAME}.campaign.report": ["*.css", "*.html", "*.js"],
        f"{NAME}.drawing": ["*.css", "*.html", "*.js"],
        f"{NAME}.nodes": ["*.xml"],
    },
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml", "requirements.lock"]),  # a bag keeps the lock file
        (f"share/{NAME}/config", CONFIG),
        (f"share/{NAME}/config/campaigns", CAMPAIGNS),
    ],
    zip_safe=False,
    python_requires=">=3.10",
    # What the core needs. ROS 2 is an extra: everything below nodes/ works without it.
    install_requires=[
        "daqp>=0.11",
        "matplotlib>=3.8",
        "mcap>=1.2",
        "numba>=0.61",
        "numpy>=1.26",
        "pillow>=10",
        "plotly>=6.0",
        "psutil>=5.9",
        "PyYAML>=6.0",
        "rich>=13",
        "rosbags>=0.10",
        "scipy>=1.11",
        "threadpoolctl>=3.1",
        "typer>=0.12",
        "zstandard>=0.22",
    ],
    extras_require=EXTRAS | {"all": sorted({need for needs in EXTRAS.values() for need in needs})},
    entry_points={
        "console_scripts": [
            f"gnc = {NAME}.__main__:main",
            f"plant = {NAME}.__main__:plant",
            f"nmpc_controller = {NAME}.__main__:nmpc_controller",
            f"reference_governor = {NAME}.__main__:reference_governor",
            f"recorder = {NAME}.__main__:recorder",
        ],
        # Vehicles, methods and laws of this package are found in its folders; another package adds
        # its own by the groups spacecraft_gnc.vehicles, .controllers and .governors.
    },
)
