#!/usr/bin/env python3
"""Trains a judge of `balanced` or `best` (crates/matching/src/refinement/choice), appends its weights.

    cargo run --release -p hazcam-training -- --preset balanced --out target/choices.bin
    python3 training/choice.py target/choices.bin --preset balanced \
        --weights crates/matching/src/refinement/choice/balanced.bin

once for each round of choices: every judge learns from what those before it left. `judges.sh` does all
of that. Needs PyTorch and numpy.

The network is that of `judge.rs`. What it is taught: to give its probability to candidates near the
truth, and little to those that are off by more than 2 px, less the farther they are off.
"""

import argparse
import math
from pathlib import Path

import numpy as np
import torch
import torch.nn.functional as F
from torch import nn

# So many numbers of each candidate, the first of them in the context (`hint.rs`), and of a pixel.
OF_EACH, IN_CONTEXT, OF_PIXEL = 20, 6, 6
# Candidates (`reach.rs`) and the numbers of the two layers (`jury.rs`).
SIZES = {"balanced": (24, 16, 8), "best": (32, 32, 16)}
BATCH = 1024
# How far what is known is off by chance where it goes into the context, which would know scenes by heart otherwise:
# by so much of itself, and by so much.
NOISE = (0.7, 0.2)


class Judge(nn.Module):
    def __init__(self, candidates, context, first, second):
        super().__init__()
        random = lambda *shape, scale: nn.Parameter(torch.randn(*shape) * scale)
        of_all = candidates * IN_CONTEXT + OF_PIXEL
        # In the order in which `judge.rs` reads them.
        self.of_all = random(context, of_all, scale=math.sqrt(1 / of_all))
        self.context_offsets = nn.Parameter(torch.zeros(context))
        common = context or OF_PIXEL
        self.of_context = random(first, common, scale=math.sqrt(1 / common) if context else 0.3)
        self.places = nn.Parameter(0.3 * torch.randn(first, 1).repeat(1, candidates))
        self.of_each = random(first, OF_EACH, scale=0.8 / math.sqrt(OF_EACH))
        self.second = random(second, first, scale=math.sqrt(2 / first))
        self.second_offsets = nn.Parameter(torch.zeros(second))
        self.last = random(second, scale=math.sqrt(1 / second))

    def forward(self, of_each, of_pixel):
        context = of_pixel
        if len(self.of_all):
            known = torch.cat([of_each[:, :IN_CONTEXT].transpose(1, 2).flatten(1), of_pixel], 1)
            if self.training:
                share, more = NOISE
                known = known * (1 + share * torch.randn_like(known)) + more * torch.randn_like(known)
            context = (known @ self.of_all.t() + self.context_offsets).relu()
        first = torch.einsum("hi,bik->bhk", self.of_each, of_each) + self.places
        first = (first + (context @ self.of_context.t())[:, :, None]).relu()
        second = torch.einsum("gh,bhk->bgk", self.second, first) + self.second_offsets[:, None]
        return torch.einsum("g,bgk->bk", self.last, second.relu())


def load(paths, candidates):
    numbers = 2 + candidates * (2 + OF_EACH) + OF_PIXEL
    ends = np.cumsum([1, 1, candidates, candidates, OF_EACH * candidates])
    for path in paths:
        size = path.stat().st_size
        if size == 0 or size % (4 * numbers):
            raise SystemExit(f"{path}: {size} bytes, but a pixel has {4 * numbers}; write it with "
                             "`cargo run --release -p hazcam-training`, of the same preset")
    files = [np.memmap(path, "<f4", "r").reshape(-1, numbers) for path in paths]
    count = sum(map(len, files))
    truth, weight = torch.empty(count, 1), torch.empty(count)
    disparities, inside = torch.empty(count, candidates), torch.empty(count, candidates, dtype=torch.bool)
    of_each = torch.empty(count, OF_EACH, candidates, dtype=torch.half)
    of_pixel = torch.empty(count, OF_PIXEL)
    # Some at a time, into their places: all of them as they are would take twice the memory.
    end = 0
    for samples in files:
        for at in range(0, len(samples), 50_000):
            parts = np.split(np.array(samples[at:at + 50_000]), ends, axis=1)
            parts = list(map(torch.from_numpy, parts))
            place = slice(end, end := end + len(parts[0]))
            truth[place], disparities[place], inside[place] = parts[0], parts[2], parts[3] > 0
            # A few pixels that stand for very many would make the steps rough.
            weight[place] = parts[1][:, 0].clamp(max=4)
            of_each[place] = parts[4].half().reshape(-1, OF_EACH, candidates)
            of_pixel[place] = parts[5]
    return truth, weight, disparities, inside, of_each, of_pixel


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("samples", type=Path, nargs="+")
    parser.add_argument("--preset", choices=SIZES, required=True, help="whose judge it is")
    parser.add_argument("--context", type=int, default=0, choices=(0, 32),
                        help="numbers that hear all candidates: 32 in every other judge of best, from the first on")
    parser.add_argument("--steps", type=int, default=15000)
    parser.add_argument("--rate", type=float, default=5e-3, help="the largest learning rate")
    parser.add_argument("--seed", type=int, default=1, help="of all that comes by chance")
    parser.add_argument("--weights", type=Path, required=True, help="the file to append to")
    arguments = parser.parse_args()
    if arguments.context and arguments.preset != "best":
        parser.error("--context: only judges of best hear all candidates")
    if arguments.steps < 1:
        parser.error(f"--steps is {arguments.steps}: at least one is needed")
    for file in (*arguments.samples, arguments.weights):
        if not file.is_file():
            parser.error(f"{file}: no such file")
    torch.manual_seed(arguments.seed)
    candidates, *layers = SIZES[arguments.preset]
    truth, weight, disparities, inside, of_each, of_pixel = load(arguments.samples, candidates)
    print(f"{len(truth)} pixels", flush=True)
    error = (disparities - truth).abs()
    near = (torch.exp(-((error / 1.2) ** 2)) + 0.02 * torch.exp(-error / 4) + 1e-6).log()
    judge = Judge(candidates, arguments.context, *layers)
    optimizer = torch.optim.AdamW(judge.parameters(), arguments.rate, weight_decay=1e-4)
    losses = []
    for step in range(arguments.steps):
        fall = (1 + math.cos(math.pi * step / arguments.steps)) / 2 + 0.01
        for group in optimizer.param_groups:
            group["lr"] = arguments.rate * fall * min(1, (step + 1) / 200)
        batch = torch.randint(len(truth), (BATCH,))
        scores = judge(of_each[batch].float(), of_pixel[batch]).masked_fill(~inside[batch], -1e9)
        likely = F.log_softmax(scores, 1)
        off = error[batch]
        expected = (likely.exp() * ((off > 2) + 0.05 * off.clamp(max=20))).sum(1)
        loss = (weight[batch] * (expected - 0.3 * torch.logsumexp(likely + near[batch], 1))).mean()
        optimizer.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_(judge.parameters(), 1.0)
        optimizer.step()
        losses.append(loss.item())
        if (step + 1) % 2000 == 0:
            print(f"{step + 1} steps: {np.mean(losses[-2000:]):.4f}", flush=True)
    numbers = np.concatenate([p.detach().numpy().astype("<f4").ravel() for p in judge.parameters()])
    beside = Path(f"{arguments.weights}.part")
    beside.write_bytes(arguments.weights.read_bytes() + numbers.tobytes())
    beside.replace(arguments.weights)
    print(f"{len(numbers)} numbers appended to {arguments.weights}")


if __name__ == "__main__":
    main()
