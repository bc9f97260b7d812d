#!/usr/bin/env python3
"""Trains the descriptors of `best` (crates/matching/src/prepare/descriptor) and writes their weights.

    pip install torch numpy pillow
    python3 training/descriptor.py --minutes 60 --out crates/matching/src/prepare/descriptor/weights.bin

Scenes: those of $HAZCAM_DATA/scenes.json whose use is `tuning`, never the others. A pixel that both
cameras see is told its match, and the network learns to tell it from all other disparities of the
row: cross-entropy over disparities (Luo, Schwing & Urtasun, CVPR 2016), of the likeness of binary
descriptors beside that of gradients. Bits are signs; gradients pass them as if they were tanh (Bengio,
Leonard & Courville 2013). Pixels beside steps of disparity count four times. Scenes are seen in a mirror
too where the right image has a truth, upside down, and from farther away. The cameras' exposure, gain,
gamma, noise, blur and vertical offset are varied, independently for each.

Takes the processors that there are. The same seed gives the same start, not the same weights: a
stretch ends by the clock.
"""

import argparse
import json
import math
import os
import random
import re
import time
from pathlib import Path

import numpy as np
import torch
import torch.nn.functional as F
from PIL import Image
from torch import nn

BITS = 64
CROP = (32, 352)
WIDE_CROP = 448  # of scenes with large disparities
ROWS = 16  # of a crop, that are compared
SCENES = 4  # of a step
# The truth of the right image, which lies beside that of the left one.
TRUTH_RIGHT = {"disp1.png": "disp5.png", "disp0GT.pfm": "disp1GT.pfm", "disp0.pfm": "disp1.pfm"}
REACH = 4  # pixels that the network sees to each side of one


class Network(nn.Module):
    """As `network.rs` has it: every pixel of the output sees REACH pixels to each side."""

    def __init__(self):
        super().__init__()
        sizes = [(1, 16, 3), (16, 16, 3), (16, 32, 3), (32, 32, 3), (32, BITS, 1)]
        self.layers = nn.ModuleList(nn.Conv2d(*size) for size in sizes)
        # Logarithms of what the parts of the likeness count; not needed to match.
        begin = {"bits": 6.0, "gradient": 0.06}
        self.part = nn.ParameterDict(
            {name: nn.Parameter(torch.tensor(math.log(value))) for name, value in begin.items()}
        )

    def forward(self, x):
        *layers, last = self.layers
        for layer in layers:
            x = layer(x).relu()
        return last(x)


def normalized(image):
    """As `normalized.rs` has it."""
    return (image - image.mean()) / (image.std() + 4)


# Scenes


def read_pfm(path):
    with open(path, "rb") as file:
        if file.readline().strip() != b"Pf":
            raise SystemExit(f"{path}: not a grey PFM file")
        width, height = map(int, file.readline().split())
        order = "<f4" if float(file.readline()) < 0 else ">f4"
        return np.frombuffer(file.read(), order).reshape(height, width)[::-1].astype(np.float32)


def read_truth(path, encoding):
    """Disparities; NaN where there is none."""
    if encoding == "pfm":
        truth = read_pfm(path)
    else:
        truth = np.asarray(Image.open(path)).astype(np.float32) / float(encoding.split("/")[1])
    return np.where(np.isfinite(truth) & (truth != 0), truth, np.nan).astype(np.float32)


def read_grey(path):
    image = np.asarray(Image.open(path))
    if image.ndim == 3:
        image = (image[..., :3].astype(np.int64) @ [299, 587, 114] + 500) // 1000
    return (image >> 8 if image.dtype == np.uint16 else image).astype(np.uint8)


def beside_steps(truth):
    """Whether the disparity steps by more than 3 px within 4 px."""
    truth = torch.from_numpy(truth)[None, None]
    largest = F.max_pool2d(torch.nan_to_num(truth, nan=-1e3), 9, 1, 4)
    least = -F.max_pool2d(torch.nan_to_num(-truth, nan=-1e3), 9, 1, 4)
    return ((largest - least > 3) & (least < 900) & (largest > -900))[0, 0].numpy()


def seen_in_row(disparities):
    """Where no nearer pixel has the same match, and the match lies inside the other image."""
    seen = np.isfinite(disparities)
    columns = np.flatnonzero(seen)
    matches = np.round(columns - disparities[columns]).astype(int)
    inside = matches >= 0
    nearest = np.full(len(disparities), -np.inf)
    np.maximum.at(nearest, matches[inside], disparities[columns[inside]])
    hidden = ~inside | (nearest[np.maximum(matches, 0)] > disparities[columns] + 1)
    seen[columns[hidden]] = False
    return seen


def load(data, held_out):
    entries = json.loads((data / "scenes.json").read_text())
    entries = [entry for entry in entries if entry.get("use") == "tuning" and entry.get("truth")]
    for part in held_out:
        # A scene would be learned from in silence.
        if not any(part in entry["id"] for entry in entries):
            known = ", ".join(entry["id"] for entry in entries)
            raise SystemExit(f"--without: no tuning scene has {part!r} in its name; {known}")
    scenes, held = [], []
    for entry in entries:
        encoding = entry.get("truth_encoding", "auto")
        if encoding == "auto" and entry["truth"].endswith(".pfm"):
            encoding = "pfm"
        if not re.fullmatch(r"pfm|png(8|16)/[0-9.]+", encoding):
            raise SystemExit(f"scenes.json, {entry['id']}: `truth_encoding` is {encoding}, but "
                             "png8/N, png16/N or pfm is needed here")
        truth = read_truth(data / entry["truth"], encoding)
        if entry.get("mask_nocc"):
            seen = np.asarray(Image.open(data / entry["mask_nocc"])) == 255
        elif entry.get("truth_noc"):
            seen = np.isfinite(read_truth(data / entry["truth_noc"], encoding))
        elif "kitti" in entry["id"]:
            seen = np.isfinite(truth)
        else:
            seen = np.isfinite(truth)
            for row, disparities in zip(seen, truth):
                row &= seen_in_row(disparities)
        scene = {
            "id": entry["id"],
            "range": entry.get("max_disparity") or math.ceil(np.nanmax(truth)),
            "left": read_grey(data / entry["left"]),
            "right": read_grey(data / entry["right"]),
            "truth": np.where(seen, truth, np.nan).astype(np.float32),
            "weight": np.where(beside_steps(truth), 4, 1).astype(np.float32),
        }
        if any(name in entry["id"] for name in held_out):
            held.append(scene)
            continue
        scenes.append(scene)
        file = data / entry["truth"]
        right = file.with_name(TRUTH_RIGHT.get(file.name, "none"))
        right = data / entry["truth_right"] if entry.get("truth_right") else right
        if right.is_file():
            scenes.append(in_a_mirror(scene, read_truth(right, encoding)))
    if not scenes:
        raise SystemExit("no tuning scene with truth is left to learn from")
    return scenes, held


def in_a_mirror(scene, truth):
    """The pair as other cameras would have seen it; `truth` is that of the right image."""
    truth = truth[:, ::-1]
    seen = np.zeros(truth.shape, bool)
    for row, disparities in zip(seen, truth):
        row[:] = seen_in_row(disparities)
    left, right = (np.ascontiguousarray(scene[name][:, ::-1]) for name in ("right", "left"))
    truth = np.where(seen, truth, np.nan)
    weight = np.where(beside_steps(truth), 4, 1).astype(np.float32)
    return {**scene, "left": left, "right": right, "truth": truth, "weight": weight}


def crop(scene, rows, columns, factor=1.0):
    """A part of a scene: both images, the truth, where it can be used, and its weight. It is seen
    from farther away by a factor of at most 1."""
    height, width = scene["left"].shape
    rows, columns = (
        min(round(size / factor), most) for size, most in ((rows, height), (columns, width))
    )
    for _ in range(20):
        y, x = random.randint(0, height - rows), random.randint(0, width - columns)
        part = np.s_[y : y + rows, x : x + columns]
        truth = scene["truth"][part]
        usable = np.isfinite(truth) & (np.arange(columns) - truth >= 0)
        if usable.sum() > 600:
            break
    images = [scene[name][part].astype(np.float32) for name in ("left", "right")]
    parts = [*images, np.nan_to_num(truth), usable, scene["weight"][part]]
    parts = [torch.from_numpy(np.ascontiguousarray(part)) for part in parts]
    return smaller(parts, factor) if factor < 1 else parts


def smaller(parts, factor):
    """A crop in fewer pixels: images are mixed, all else is that of the nearest one."""
    size = [int(side * factor) for side in parts[0].shape]
    scaled = lambda part, mode: F.interpolate(part.float()[None, None], size=size, mode=mode)[0, 0]
    left, right = (scaled(image, "area") for image in parts[:2])
    # By the columns that there are, which need not be the factor's.
    truth = scaled(parts[2], "nearest-exact") * (size[1] / parts[2].shape[1])
    usable, weight = (scaled(part, "nearest-exact") for part in parts[3:])
    usable = (usable > 0) & (torch.arange(size[1]) - truth >= 0)
    return [left, right, truth, usable, weight]


# What differs between cameras


def blurred(image, k):
    kernel = torch.tensor([k, 1 - 2 * k, k])
    image = F.pad(image[None, None], (1, 1, 1, 1), mode="replicate")
    return F.conv2d(F.conv2d(image, kernel.view(1, 1, 3, 1)), kernel.view(1, 1, 1, 3))[0, 0]


def photographed(image):
    """With gain, gamma, exposure, uneven light and noise of its own."""
    image = 255 * (image / 255).clamp(min=0) ** math.exp(random.gauss(0, 0.1))
    image = image * math.exp(random.gauss(0, 0.1)) + random.gauss(0, 6)
    if random.random() < 0.3:
        ramps = [torch.linspace(-1, 1, size) * random.gauss(0, 0.1) for size in image.shape]
        image = image * (1 + ramps[0][:, None] + ramps[1])
    image = image + torch.randn_like(image) * random.choice([0, 0, 1, 2, 4])
    return image.clamp(0, 255).round()


def varied(left, right, *others):
    if random.random() < 0.5:
        left, right, *others = (part.flip(0) for part in (left, right, *others))
    left, right = (
        blurred(image, random.random() / 4) if random.random() < 0.2 else image
        for image in (left, right)
    )
    if random.random() < 0.3:
        offset = random.uniform(-0.7, 0.7)
        whole = math.floor(offset)
        fraction = offset - whole
        right = (1 - fraction) * right.roll(whole, 0) + fraction * right.roll(whole + 1, 0)
    if random.random() < 0.3:
        contrast = random.uniform(0.4, 1.0)
        left, right = contrast * left, contrast * right
    return photographed(left), photographed(right), *others


# Likeness


def gradient(image, rows):
    padded = F.pad(image[None, None], (1, 1, 0, 0), mode="replicate")[0, 0]
    return (padded[:, 2:] - padded[:, :-2])[rows]


def loss(network, outputs, images, truth, usable, weight, rows, most):
    """Cross-entropy over the disparities of each pixel, and the share of winners that are wrong."""
    signs = [output.sign().detach() + output.tanh() - output.tanh().detach() for output in outputs]
    part = {name: value.exp() for name, value in network.part.items()}
    left, right = (bits * (part["bits"] / BITS).sqrt() for bits in signs)
    # Of all columns of the left row with all of the right one.
    like = torch.bmm(left.permute(1, 2, 0), right.permute(1, 0, 2))
    steps = [gradient(image, rows) for image in images]
    unlike = (steps[0][:, :, None] - steps[1][:, None, :]).abs().clamp(max=20)
    columns = torch.arange(like.shape[-1])
    disparity = columns[:, None] - columns
    outside = torch.where((disparity < 0) | (disparity > most), -1e4, 0.0)
    like = F.log_softmax(like - part["gradient"] * unlike + outside, -1)
    # The match lies between two columns, and both are right.
    match = columns - truth
    lower = match.floor().long().clamp(0, len(columns) - 1)
    upper = (lower + 1).clamp(0, len(columns) - 1)
    fraction = match - match.floor()
    at = lambda column: like.gather(2, column[..., None])[..., 0]
    entropy = -(at(lower) * (1 - fraction) + at(upper) * fraction)
    with torch.no_grad():
        wrong = ((like.argmax(-1) - match).abs() > 3)[usable].float().mean().item()
    return (entropy * weight)[usable].sum() / weight[usable].sum(), wrong


def step(network, scene, shape, vary):
    factor = random.uniform(0.4, 1) if vary and random.random() < 0.5 else 1.0
    parts = crop(scene, *shape, factor)
    if vary:
        parts = varied(*parts)
    x = torch.stack([normalized(image) for image in parts[:2]])[:, None]
    with torch.autocast("cpu", torch.bfloat16):
        outputs = network(x.contiguous(memory_format=torch.channels_last))
    # Of the crop's border nothing is known.
    left, right, truth, usable, weight = (p[REACH:-REACH, REACH:-REACH] for p in parts)
    usable = usable & (torch.arange(truth.shape[1]) - truth >= 0)
    known = usable.sum(1).float()
    if not usable.any():
        return step(network, scene, shape, vary)
    rows = torch.multinomial(known, min(ROWS, int((known > 0).sum())))
    outputs = outputs.float()[:, :, rows]
    images = (left, right)
    return loss(
        network, outputs, images, truth[rows], usable[rows], weight[rows], rows, scene["range"]
    )


def read_weights(network, path):
    """What `write_weights` wrote."""
    numbers = np.fromfile(path, "<u2")
    if len(numbers) != (needed := sum(p.numel() for p in network.layers.parameters())):
        raise SystemExit(f"{path}: {len(numbers)} numbers, but the network has {needed}; "
                         "--start takes what --out leaves")
    numbers = (numbers.astype(np.uint32) << 16).view(np.float32)
    for layer in network.layers:
        out, inside, side, _ = layer.weight.shape
        weight, numbers = np.split(numbers, [layer.weight.numel()])
        bias, numbers = np.split(numbers, [out])
        weight = weight.reshape(out // 16, side, side, inside, 16).transpose(0, 4, 3, 1, 2)
        with torch.no_grad():
            layer.weight.copy_(torch.from_numpy(weight.reshape(out, inside, side, side).copy()))
            layer.bias.copy_(torch.from_numpy(bias.copy()))


def write_weights(network, path):
    """In the order that `network.rs` reads them: the upper halves of 32-bit floats."""

    def upper(numbers):
        bits = np.ascontiguousarray(numbers, dtype=np.float32).view(np.uint32)
        return ((bits + 0x7FFF + (bits >> 16 & 1)) >> 16).astype("<u2").ravel()

    parts = []
    for layer in network.layers:
        weight = layer.weight.detach().numpy()
        out, inside, side, _ = weight.shape
        groups = weight.reshape(out // 16, 16, inside, side, side)
        parts += [upper(groups.transpose(0, 3, 4, 2, 1)), upper(layer.bias.detach().numpy())]
    beside = Path(f"{path}.part")
    np.concatenate(parts).tofile(beside)
    beside.replace(path)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--data", type=Path, default=os.environ.get("HAZCAM_DATA"))
    parser.add_argument("--minutes", type=float, default=60)
    parser.add_argument("--rate", type=float, default=1.5e-3, help="the largest learning rate")
    parser.add_argument("--without", nargs="*", default=[], help="scenes to judge by: parts of ids")
    parser.add_argument("--start", type=Path, help="weights to go on from, as --out leaves them")
    parser.add_argument("--out", type=Path, required=True,
                        help="where the weights go, after every 500 steps too")
    arguments = parser.parse_args()
    if arguments.data is None:
        parser.error("no scenes: set HAZCAM_DATA or give --data")
    for file in (arguments.data / "scenes.json", arguments.start):
        if file is not None and not file.is_file():
            parser.error(f"{file}: no such file; --data names the folder with scenes.json, "
                         "--start weights")
    if not arguments.out.parent.is_dir():
        parser.error(f"--out: there is no folder {arguments.out.parent}")
    if arguments.minutes <= 0:
        parser.error(f"--minutes is {arguments.minutes:g}: more than 0 are needed")
    random.seed(1)
    torch.manual_seed(1)
    scenes, held = load(arguments.data, arguments.without)
    print(f"{len(scenes)} scenes to learn from, {len(held)} to judge by", flush=True)
    network = Network().to(memory_format=torch.channels_last)
    if arguments.start:
        read_weights(network, arguments.start)
    layers, parts = list(network.layers.parameters()), list(network.part.parameters())
    optimizer = torch.optim.AdamW(
        [{"params": layers, "times": 1}, {"params": parts, "times": 5, "weight_decay": 0}],
        arguments.rate,
        weight_decay=1e-4,
    )
    # The views of the moon are much alike.
    chances = [0.35 if "lunar" in scene["id"] else 1.0 for scene in scenes]
    begun, steps, record = time.time(), 0, []
    while (elapsed := (time.time() - begun) / 60 / arguments.minutes) < 1:
        fall = (1 + math.cos(math.pi * elapsed)) / 2 + 0.01
        for group in optimizer.param_groups:
            group["lr"] = arguments.rate * group["times"] * fall * min(1, steps / 100)
        optimizer.zero_grad()
        for scene in random.choices(scenes, chances, k=SCENES):
            columns = WIDE_CROP if scene["range"] > 120 else CROP[1]
            entropy, wrong = step(network, scene, (CROP[0], columns), True)
            entropy.backward()
            record.append((entropy.item(), wrong))
        nn.utils.clip_grad_norm_(network.parameters(), 1.0)
        optimizer.step()
        steps += 1
        if steps % 250 == 0:
            entropy, wrong = np.mean(record, 0)
            record = []
            print(f"{steps} steps: entropy {entropy:.3f}, wrong {wrong:.3f}", flush=True)
        if steps % 500 == 0:
            write_weights(network, arguments.out)
    if held:
        with torch.no_grad():
            judged = [step(network, s, (96, 448), False) for s in held for _ in range(5)]
        entropy, wrong = np.mean([(float(e), w) for e, w in judged], 0)
        print(f"held out: entropy {entropy:.3f}, wrong {wrong:.3f}")
    write_weights(network, arguments.out)
    parts = ", ".join(f"{name} {value.exp().item():.3f}" for name, value in network.part.items())
    print(f"{steps} steps; the parts count {parts}; {arguments.out} written")


if __name__ == "__main__":
    main()
