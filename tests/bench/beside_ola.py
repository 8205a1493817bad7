#!/usr/bin/env python3
"""Measures Footlight's bridge beside OLA's, turn and turn about on two hosts joined by a cable.

    sudo tests/bench/beside_ola.py --build build/release [--seconds 20] [--turns 3] [--rates 44,1000] [--plot docs/x.svg]

Needs root for the network namespaces, Debian's packages ola and iproute2, and a build with -DFOOTLIGHT_BENCH=ON. Both
hosts are namespaces of this machine and nothing leaves it. Prints Markdown: one row a bridge and rate, the median of the
turns. "floor" has no bridge: the generator is heard directly, one crossing of the cable instead of two.

OLA 0.10 sends at most four Art-Net universes, so of its nine only those four are listened to. OLA runs at normal priority;
Footlight is measured there too, and with the real-time priority that it asks for by default. At real-time priority the
kernel hands the packets that a process sends to their receiver (the other namespace) within that process, at normal
priority often in a thread of its own that no process is charged for: compare CPU at equal priority.
"""
import argparse
import json
import math
import os
import pathlib
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

HOST_A, HOST_B = "footlight-a", "footlight-b"
ADDRESS_A, ADDRESS_B = "10.77.0.1", "10.77.0.2"
GROUPS = "239.255.0.0/16"


def sh(*words, **options):
    return subprocess.run(words, check=True, **options)


def lay_cable():
    remove_cable()
    for host in (HOST_A, HOST_B):
        sh("ip", "netns", "add", host)
        sh("ip", "-n", host, "link", "set", "lo", "up")
    sh("ip", "link", "add", "va", "netns", HOST_A, "type", "veth", "peer", "name", "vb", "netns", HOST_B)
    for host, device, address in ((HOST_A, "va", ADDRESS_A), (HOST_B, "vb", ADDRESS_B)):
        sh("ip", "-n", host, "addr", "add", address + "/24", "brd", "+", "dev", device)
        sh("ip", "-n", host, "link", "set", device, "up")
        sh("ip", "-n", host, "route", "add", GROUPS, "dev", device)


def remove_cable():
    for host in (HOST_A, HOST_B):
        subprocess.run(["ip", "netns", "del", host], stderr=subprocess.DEVNULL, check=False)


def on(host, *words):
    return ["ip", "netns", "exec", host, *words]


class Ola:
    """olad with nine sACN inputs and four Art-Net outputs. It refuses to be root."""

    name = "OLA"
    universes = 9
    heard = "artnet:2-5=1-4"  # OLA's universe N is Art-Net's port address N, which counts from 0

    def start(self):
        self.folder = tempfile.mkdtemp(prefix="ola-")
        plugins = ("dummy espnet ftdidmx gpio karate kinet milinst opendmx openpixelcontrol osc pathport renard sandnet "
                   "shownet spi stageprofi uartdmx usbdmx usbserial").split()
        files = {plugin: "enabled = false\n" for plugin in plugins}
        files["artnet"] = f"enabled = true\nip = {ADDRESS_B}\nalways_broadcast = true\noutput_ports = 4\n"
        files["e131"] = f"enabled = true\nip = {ADDRESS_B}\ninput_ports = 9\noutput_ports = 5\n"
        for plugin, text in files.items():
            pathlib.Path(self.folder, f"ola-{plugin}.conf").write_text(text)
        for path in (self.folder, *pathlib.Path(self.folder).iterdir()):
            shutil.chown(path, "olad")
        as_olad = ["setpriv", "--reuid=olad", "--regid=nogroup", "--clear-groups"]
        # Without D-Bus its service discovery tries again without a pause and keeps a third of a core busy.
        self.process = subprocess.Popen(on(HOST_B, *as_olad, "olad", "-c", self.folder, "--no-http",
                                           "--no-register-with-dns-sd", "-l", "1"),
                                        stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        deadline = time.monotonic() + 20
        while time.monotonic() < deadline:
            listed = subprocess.run(on(HOST_B, "ola_dev_info"), capture_output=True, text=True, check=False).stdout
            devices = {line.split(":")[1].split()[0]: line.split()[1].rstrip(":")
                       for line in listed.splitlines() if line.startswith("Device")}
            if {"ArtNet", "E1.31"} <= devices.keys():
                break
            time.sleep(0.2)
        else:
            sys.exit("olad did not start; try: olad -l 3")
        quiet = {"stdout": subprocess.DEVNULL}
        for port in range(9):
            sh(*on(HOST_B, "ola_patch", "-d", devices["E1.31"], "-p", str(port), "-i", "-u", str(port + 1)), **quiet)
        for port in range(4):
            sh(*on(HOST_B, "ola_patch", "-d", devices["ArtNet"], "-p", str(port), "-u", str(port + 1)), **quiet)

    def stop(self):
        self.process.terminate()
        self.process.wait()
        shutil.rmtree(self.folder)


class Footlight:
    """All nine out, unless as few as OLA can are asked for; with OLA's own, normal priority unless real-time is."""

    def __init__(self, build, out=9, realtime=False):
        self.universes = 9
        self.name = f"Footlight, {out} out" + (", real-time" if realtime else "")
        self.heard = f"artnet:1-{out}"
        self.words = [str(build / "bin/footlight"), "run", "--in", "sacn:1-9%vb", "--out", f"artnet:1-{out}@{ADDRESS_A}"]
        if not realtime:
            self.words.append("--no-realtime")

    def start(self):
        self.process = subprocess.Popen(on(HOST_B, *self.words), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(0.5)

    def stop(self):
        self.process.terminate()
        self.process.wait()


def measure(build, bridge, rate_hz, seconds, latencies):
    words = [str(build / "tools/bench_wire"), "--json", "--rate", str(rate_hz), "--seconds", str(seconds),
             "--to", "sacn:1-9%va", "--latencies", latencies]
    if bridge is None:
        words += ["--floor"]
    else:
        words += ["--from", bridge.heard, "--pid", str(bridge.process.pid)]
    done = subprocess.run(on(HOST_A, *words), capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(done.stderr)
    result = json.loads(done.stdout)
    if bridge is not None:
        status = pathlib.Path(f"/proc/{bridge.process.pid}/status").read_text()
        result["rss_mb"] = int(status.split("VmRSS:")[1].split()[0]) / 1024
    return result


def median(results, key):
    values = [result[key] for result in results if key in result]
    return statistics.median(values) if values else None


def row(name, rate_hz, results):
    sent = sum(result["sent"] for result in results)
    lost = sum(result["lost"] for result in results)
    cpu = median(results, "cpu_percent")
    rss = median(results, "rss_mb")
    times = [f"{median(results, key):.0f}" for key in ("p50_us", "p90_us", "p99_us")]
    return (f"| {name} | {results[0]['universes']} x {rate_hz:g} Hz | " + ("-" if cpu is None else f"{cpu:.2f} %") + " | " +
            " | ".join(times) + f" | {lost} of {sent} | " + ("-" if rss is None else f"{rss:.1f} MB") + " |")


def plot(path, title, curves):
    """Histograms of latency over decades of microseconds, one step line a curve."""
    width, height, left, bottom, top = 720, 360, 60, 50, 40
    low, high, bins_per_decade = 1.0, 5.0, 12  # 10 us to 100 ms
    bins = int((high - low) * bins_per_decade)
    shares = {}
    for name, latencies_ns in curves.items():
        counts = [0] * bins
        for ns in latencies_ns:
            at = (math.log10(max(ns, 1) / 1000) - low) * bins_per_decade
            counts[min(max(int(at), 0), bins - 1)] += 1
        shares[name] = [count / max(len(latencies_ns), 1) for count in counts]
    share_max = max(max(values) for values in shares.values())
    x = lambda i: left + (width - left - 20) * i / bins
    y = lambda share: height - bottom - (height - bottom - top) * share / share_max
    colours = ["#888888", "#d9822b", "#2b6cb0", "#2f855a", "#805ad5"]
    lines = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" '
             f'font-size="12"><rect width="{width}" height="{height}" fill="#ffffff"/>',
             f'<text x="{left}" y="20" font-size="14">{title}</text>']
    for decade, label in enumerate(("10 us", "100 us", "1 ms", "10 ms", "100 ms")):
        at = x(decade * bins_per_decade)
        lines.append(f'<path d="M{at:.1f} {top}V{height - bottom}" stroke="#dddddd"/>'
                     f'<text x="{at:.1f}" y="{height - bottom + 18}" text-anchor="middle">{label}</text>')
    lines.append(f'<text x="{left + (width - left) / 2:.0f}" y="{height - 10}" text-anchor="middle">'
                 f'latency; height: share of frames in a twelfth of a decade, at most {100 * share_max:.0f} %</text>')
    for i, (name, values) in enumerate(shares.items()):
        path_words = f"M{x(0):.1f} {y(0):.1f}" + "".join(
            f"V{y(value):.1f}H{x(at + 1):.1f}" for at, value in enumerate(values)) + f"V{y(0):.1f}"
        lines.append(f'<path d="{path_words}" fill="none" stroke="{colours[i % len(colours)]}" stroke-width="2"/>'
                     f'<text x="{width - 170}" y="{top + 16 * (i + 1)}" fill="{colours[i % len(colours)]}">{name}</text>')
    pathlib.Path(path).write_text("\n".join(lines) + "\n</svg>\n")


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--build", type=pathlib.Path, default=pathlib.Path("build/release"))
    options.add_argument("--seconds", type=float, default=20)
    options.add_argument("--turns", type=int, default=3)
    options.add_argument("--rates", default="44")
    options.add_argument("--plot", help="write an SVG of the latencies at the first rate")
    wanted = options.parse_args()
    build = wanted.build.resolve()
    if os.geteuid() != 0:
        sys.exit("network namespaces need root; try sudo")
    print("| bridge | universes | CPU of one core | p50 us | p90 us | p99 us | lost | memory |")
    print("|---|---|---|---|---|---|---|---|")
    lay_cable()
    try:
        for number, rate_hz in enumerate(float(text) for text in wanted.rates.split(",")):
            bridges = [None, Ola(), Footlight(build, out=4), Footlight(build), Footlight(build, realtime=True)]
            results = {("floor" if bridge is None else bridge.name): [] for bridge in bridges}
            latencies = {name: [] for name in results}
            for _ in range(wanted.turns):
                for bridge in bridges:
                    if bridge is not None:
                        bridge.start()
                    try:
                        with tempfile.NamedTemporaryFile("r", prefix="latencies-") as file:
                            name = "floor" if bridge is None else bridge.name
                            results[name].append(measure(build, bridge, rate_hz, wanted.seconds, file.name))
                            latencies[name] += [int(line) for line in file]
                    finally:
                        if bridge is not None:
                            bridge.stop()
            for name, measured in results.items():
                print(row(name, rate_hz, measured), flush=True)
            if wanted.plot and number == 0:
                plot(wanted.plot, f"sACN to Art-Net, 9 universes at {rate_hz:g} Hz, two hosts on one machine", latencies)
    finally:
        remove_cable()


if __name__ == "__main__":
    main()
