#!/usr/bin/env python3
"""Trains the descriptors of `best` (crates/matching/src/prepare/descriptor) and writes their weights.

    pip install torch numpy pillow
    python3 training/descriptor.py --minutes 90 --out crates/matching/src/prepare/descriptor/weights.bin

Scenes: those of $HAZCAM_DATA/scenes.json whose use is `tuning`, never the others. A pixel that both
cameras see is told its match, and the network learns to tell it from all other disparities of the
row: cross-entropy over disparities (Luo, Schwing & Urtasun, CVPR 2016), of the likeness of binary
descriptors beside that of census and gradient, so that descriptors learn what these two lack. Bits
are signs; gradients pass them as if they were tanh (Bengio, Leonard & Courville 2013). Pixels beside
steps of disparity count four times. The cameras' exposure, gain, gamma, noise, blur and vertical
offset are varied, independently for each.

Takes the processors that there are. The same seed gives the same start, not the same weights: a
stretch ends by the clock.
"""

import argparse
import json
import math
import os
import random
import time
from pathlib import Path

import numpy as np
import torch
import torch.nn.functional as F
from PIL import Image
from torch import nn

BITS = 64
CROP = (52, 352)
WIDE_CROP = 448  # of scenes with large disparities
ROWS = 14  # of a crop, that are compared
LAYERS = "a1 a2 b1 b2 c1 c2 c3 b3 b4 b5 a3 a4 a5".split()


class Network(nn.Module):
    """As `network.rs` has it: three sizes, the coarser ones added to the finer."""

    def __init__(self):
        super().__init__()
        conv = lambda i, o, stride=1: nn.Conv2d(i, o, 3, stride, 1)
        self.a1, self.a2 = conv(1, 16), conv(16, 16)
        self.b1, self.b2 = conv(16, 32, 2), conv(32, 32)
        self.c1, self.c2, self.c3 = conv(32, 48, 2), conv(48, 48), nn.Conv2d(48, 32, 1)
        self.b3, self.b4, self.b5 = nn.Conv2d(32, 32, 1), conv(32, 32), nn.Conv2d(32, 32, 1)
        self.a3, self.a4, self.a5 = nn.Conv2d(16, 32, 1), conv(32, 32), nn.Conv2d(32, BITS, 1)
        # Logarithms of what the three parts of the likeness count; not needed to match.
        begin = {"bits": 6.0, "census": 2.0, "gradient": 0.06}
        self.part = nn.ParameterDict(
            {name: nn.Parameter(torch.tensor(math.log(value))) for name, value in begin.items()}
        )

    def forward(self, x):
        height, width = x.shape[-2:]
        x = F.pad(x, (0, -width % 4, 0, -height % 4), mode="replicate")
        twice = lambda x: F.interpolate(x, scale_factor=2, mode="bilinear")
        a = self.a2(self.a1(x).relu()).relu()
        b = self.b2(self.b1(a).relu()).relu()
        c = self.c3(self.c2(self.c1(b).relu()).relu())
        b = self.b5(self.b4((self.b3(b) + twice(c)).relu()).relu())
        a = self.a5(self.a4((self.a3(a) + twice(b)).relu()).relu())
        return a[..., :height, :width]


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
    return (image // 257 if image.dtype == np.uint16 else image).astype(np.uint8)


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
    scenes, held = [], []
    for entry in entries:
        if entry["use"] != "tuning":
            continue
        truth = read_truth(data / entry["truth"], entry["truth_encoding"])
        if entry.get("mask_nocc"):
            seen = np.asarray(Image.open(data / entry["mask_nocc"])) == 255
        elif entry.get("truth_noc"):
            seen = np.isfinite(read_truth(data / entry["truth_noc"], entry["truth_encoding"]))
        elif "kitti" in entry["id"]:
            seen = np.isfinite(truth)
        else:
            seen = np.isfinite(truth)
            for row, disparities in zip(seen, truth):
                row &= seen_in_row(disparities)
        scene = {
            "id": entry["id"],
            "range": entry["max_disparity"],
            "left": read_grey(data / entry["left"]),
            "right": read_grey(data / entry["right"]),
            "truth": np.where(seen, truth, np.nan).astype(np.float32),
            "weight": np.where(beside_steps(truth), 4, 1).astype(np.float32),
        }
        (held if any(name in entry["id"] for name in held_out) else scenes).append(scene)
    return scenes, held


def crop(scene, rows, columns):
    """A part of a scene: both images, the truth, where it can be used, and its weight."""
    height, width = scene["left"].shape
    rows, columns = min(rows, height), min(columns, width)
    for _ in range(20):
        y, x = random.randint(0, height - rows), random.randint(0, width - columns)
        part = np.s_[y : y + rows, x : x + columns]
        truth = scene["truth"][part]
        usable = np.isfinite(truth) & (np.arange(columns) - truth >= 0)
        if usable.sum() > 400:
            break
    images = [scene[name][part].astype(np.float32) for name in ("left", "right")]
    parts = [*images, np.nan_to_num(truth), usable, scene["weight"][part]]
    return [torch.from_numpy(np.ascontiguousarray(part)) for part in parts]


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


def census(image, rows):
    """1 or -1 for each of the 32 neighbours of `prepare/census.rs`."""
    height, width = image.shape
    padded = F.pad(image[None, None], (3, 3, 2, 2), mode="replicate")[0, 0]
    left_out = {(0, 0), (-2, -3), (2, 3)}
    signs = [
        torch.where(padded[2 + v : 2 + v + height, 3 + u : 3 + u + width] < image, 1.0, -1.0)[rows]
        for v in range(-2, 3)
        for u in range(-3, 4)
        if (v, u) not in left_out
    ]
    return torch.stack(signs) / math.sqrt(len(signs))


def gradient(image, rows):
    padded = F.pad(image[None, None], (1, 1, 0, 0), mode="replicate")[0, 0]
    return (padded[:, 2:] - padded[:, :-2])[rows]


def loss(network, outputs, images, truth, usable, weight, rows, most):
    """Cross-entropy over the disparities of each pixel, and the share of winners that are wrong."""
    signs = [output.sign().detach() + output.tanh() - output.tanh().detach() for output in outputs]
    part = {name: value.exp() for name, value in network.part.items()}
    left, right = (
        torch.cat([
            bits * (part["bits"] / BITS).sqrt(),
            census(image, rows) * part["census"].sqrt(),
        ])
        for bits, image in zip(signs, images)
    )
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
    left, right, truth, usable, weight = crop(scene, *shape)
    if vary:
        left, right, truth, usable, weight = varied(left, right, truth, usable, weight)
    x = torch.stack([normalized(left), normalized(right)])[:, None]
    with torch.autocast("cpu", torch.bfloat16):
        outputs = network(x.contiguous(memory_format=torch.channels_last))
    known = usable.sum(1).float()
    rows = torch.multinomial(known, min(ROWS, int((known > 0).sum())))
    outputs = outputs.float()[:, :, rows]
    images = (left, right)
    return loss(
        network, outputs, images, truth[rows], usable[rows], weight[rows], rows, scene["range"]
    )


def write_weights(network, path):
    """In the order that `network.rs` reads them: the upper halves of 32-bit floats."""

    def upper(numbers):
        bits = np.ascontiguousarray(numbers, dtype=np.float32).view(np.uint32)
        return ((bits + 0x7FFF + (bits >> 16 & 1)) >> 16).astype("<u2").ravel()

    parts = []
    for name in LAYERS:
        layer = getattr(network, name)
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
    parser.add_argument("--minutes", type=float, default=90)
    parser.add_argument("--rate", type=float, default=1.5e-3, help="the largest learning rate")
    parser.add_argument("--without", nargs="*", default=[], help="scenes to judge by: parts of ids")
    parser.add_argument("--resume", type=Path, help="a checkpoint to go on from")
    parser.add_argument("--checkpoint", type=Path, default=Path("target/descriptor.pt"))
    parser.add_argument("--out", type=Path, required=True, help="where the weights go")
    arguments = parser.parse_args()
    if arguments.data is None:
        parser.error("no scenes: set HAZCAM_DATA or give --data")
    for file in (arguments.data / "scenes.json", arguments.resume):
        if file is not None and not file.is_file():
            parser.error(f"{file}: no such file; --data names the folder with scenes.json, "
                         "--resume a checkpoint")
    random.seed(1)
    torch.manual_seed(1)
    scenes, held = load(arguments.data, arguments.without)
    print(f"{len(scenes)} scenes to learn from, {len(held)} to judge by", flush=True)
    network = Network().to(memory_format=torch.channels_last)
    if arguments.resume:
        network.load_state_dict(torch.load(arguments.resume))
    parts = list(network.part.parameters())
    layers = [p for name, p in network.named_parameters() if not name.startswith("part.")]
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
        for scene in random.choices(scenes, chances, k=2):
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
        if steps % 1000 == 0:
            arguments.checkpoint.parent.mkdir(parents=True, exist_ok=True)
            torch.save(network.state_dict(), arguments.checkpoint)
    torch.save(network.state_dict(), arguments.checkpoint)
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
