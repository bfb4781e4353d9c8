"""Compares a job's XML with what OpenCue's own pyoutline writes for the same job, and applies rules of the server that its writer does
not.

Usage: opencue.py FILE
"""

import re
import sys
import tempfile
import xml.etree.ElementTree as Tree

import outline
import outline.cuerun
from outline.depend import DependType
from outline.modules.shell import Shell

# Written by pyoutline whether a job says anything of it or not; all are optional.
LEFT_OUT = {"priority", "env", "outputs"}
# Whoever writes is in it.
THEIRS = {"uid"}
# The server's rules for a layer's or a shot's name, and for the job's.
NAME = re.compile(r"[\w.]{3,}")
# More retries than this are cut by the server without a word.
MOST_RETRIES = 1


def words(element, path=""):
    """All elements with their attributes and text, in the order of the file."""
    path = f"{path}/{element.tag}"
    if element.tag in LEFT_OUT:
        return
    text = (element.text or "").strip()
    yield path, sorted(element.attrib.items()), "" if element.tag in THEIRS else text
    for child in element:
        yield from words(child, path)


def theirs(job):
    """The same job by pyoutline: names, commands and ranges are the file's, all else is its own."""
    found = job.find("job")
    job_outline = outline.Outline(found.get("name"), show=job.findtext("show"), shot=job.findtext("shot"))
    layers = {}
    for layer in found.find("layers"):
        name = layer.get("name")
        layers[name] = Shell(name, command=layer.findtext("cmd"), range=layer.findtext("range"), type=layer.get("type"))
        job_outline.add_layer(layers[name])
    layers["merge"].depend_on(layers["parts"], DependType.LayerOnLayer)
    retries = int(found.findtext("maxretries"))
    launcher = outline.cuerun.OutlineLauncher(job_outline, pause=False, maxretries=retries, nomail=True, user=job.findtext("user"))
    return Tree.fromstring(launcher.serialize(use_pycuerun=False))


def judged_by_the_server(job):
    """What is wrong by the rules that are applied where a job is launched."""
    found = job.find("job")
    names = [job.findtext("shot"), found.get("name")] + [layer.get("name") for layer in found.find("layers")]
    for name in names:
        if not NAME.fullmatch(name):
            yield f"{name} is no name"
    for layer in found.find("layers"):
        # These go into a job of their own, where a dependency on a layer of this one finds nothing.
        if layer.get("type") == "Post":
            yield f"the layer {layer.get('name')} would be none of this job's"
    if int(found.findtext("maxretries")) > MOST_RETRIES:
        yield "more retries than there will be"
    if job.findtext("user") == "root" or job.findtext("uid") == "0":
        yield "a job of root's is refused"


def main():
    path = sys.argv[1]
    job = Tree.parse(path).getroot()
    with tempfile.TemporaryDirectory() as folder:
        outline.config.set("outline", "session_dir", folder)
        own, wanted = list(words(job)), list(words(theirs(job)))
    wrong = list(judged_by_the_server(job))
    wrong += [f"{found} where pyoutline writes {other}" for found, other in zip(own, wanted) if found != other]
    if len(own) != len(wanted):
        wrong.append(f"{len(own)} elements where pyoutline writes {len(wanted)}")
    if wrong:
        sys.exit("\n".join(f"{path}: {what}" for what in wrong))
    print(f"{path}: {len(own)} elements, as pyoutline writes them")


main()
