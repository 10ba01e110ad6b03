"""Somebody who knows how a store is made: changes what it says, and writes every hash anew so that all of it fits."""

import hashlib
import json

from grazing.sweep import manifest


def compact(document):
    """Return JSON as stores write it."""
    return json.dumps(document, separators=(",", ":"))


def forged(store, change):
    """Let ``change`` edit the metadata by file, the layout and the prints of coordinates; bind the store to that.

    The configuration's hash, and what the store lists of its arrays, follow, unless they were edited themselves.
    """
    template = manifest.read_template(store)
    metadata = {file: json.loads(text) for file, text in template.metadata.items()}
    attrs = metadata["zarr.json"]["attributes"]
    layout, prints = json.loads(attrs["grazing_sweep"]), dict(template.coordinates)
    fitting, root = attrs["grazing_config_sha256"], metadata["zarr.json"]
    before = compact(root.get("consolidated_metadata"))
    change(metadata, layout, prints)
    if before != "null" and before == compact(root.get("consolidated_metadata")):
        arrays = {file.removesuffix("/zarr.json"): own for file, own in metadata.items() if file != "zarr.json"}
        root["consolidated_metadata"]["metadata"] = arrays
    attrs["grazing_sweep"] = compact(layout)
    config = attrs.get("grazing_config")
    if isinstance(config, str) and attrs.get("grazing_config_sha256") == fitting:
        attrs["grazing_config_sha256"] = hashlib.sha256(config.encode(errors="replace")).hexdigest()
    texts = {file: compact(document) for file, document in metadata.items()}
    for file, text in texts.items():
        if ".." not in file and not file.startswith("/"):
            (store / file).parent.mkdir(parents=True, exist_ok=True)
            (store / file).write_text(text)
    bound(store, texts, prints)
    return store


def bound(store, texts, prints):
    """Write template, records and seal that fit."""
    content = manifest.template_lines(texts, prints)
    (store / manifest.TEMPLATE).write_bytes(content)
    identity, records = content.split(b"\n")[1].decode(), []
    for file in sorted((store / manifest.CHUNKS).iterdir(), key=lambda file: int(file.name)):
        body = json.loads(file.read_bytes().split(b"\n")[0])
        for key in body["files"]:
            raw = (store / key).read_bytes()
            body["files"][key] = [len(raw), hashlib.sha256(raw).hexdigest()]
        file.write_bytes(manifest.lines({**body, "store": identity}))
        records.append(file.read_bytes().split(b"\n")[1].decode())
    (store / manifest.SEAL).write_bytes(manifest.seal_lines(identity, records))
