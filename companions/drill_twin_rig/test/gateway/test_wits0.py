# SPDX-License-Identifier: Apache-2.0
"""WITS level 0 over a real TCP connection: items, what is no item, and a server that goes and comes back."""

import math
import socket
import threading
import time

import pytest

from drill_twin_rig.gateway.signals import RigSignal
from drill_twin_rig.gateway.wits0 import SentenceReader, WitsReader

WOB = RigSignal("weight_on_bit", "kdaN", 1e4, "wits=0116", -math.inf, math.inf, 2.0, 0.0)
TORQUE = RigSignal("surface_torque", "kN m", 1e3, "wits=0118", -math.inf, math.inf, 2.0, 0.0)


class Rig:
    """A server that sends bytes to the one who connects."""

    def __init__(self):
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port = self._listener.getsockname()[1]
        self._connections = []
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self):
        while True:
            try:
                self._connections.append(self._listener.accept()[0])
            except OSError:
                return

    def send(self, text):
        _until(lambda: self._connections)
        self._connections[-1].sendall(text.encode("ascii", "replace"))

    def drop(self):
        for one in self._connections:
            one.close()
        self._connections.clear()

    def close(self):
        self.drop()
        self._listener.close()


@pytest.fixture
def rig():
    rig = Rig()
    yield rig
    rig.close()


@pytest.fixture
def reader(rig):
    reader = WitsReader(f"wits://127.0.0.1:{rig.port}", [WOB, TORQUE])
    yield reader
    reader.close()


def _until(happened, seconds=20.0):
    end = time.monotonic() + seconds
    while not happened():
        assert time.monotonic() < end
        time.sleep(0.01)


@pytest.mark.parametrize(
    ("lines", "items"),
    [
        (("&&", "01163.25", "0118 12.5 ", "!!"), {"0116": "3.25", "0118": "12.5"}),
        (("01163.25", "!!"), None),
        (("&&", "01161.0", "&&", "01182.0", "!!"), {"0118": "2.0"}),
        (("&&", "abcd1", "", "01", "01161.0", "!!"), {"0116": "1.0"}),
    ],
)
def test_sentences(lines, items):
    sentences = SentenceReader()
    assert [sentences.take(line) for line in lines][-1] == items


def test_a_rig_is_read_in_si_and_read_again_after_it_was_gone(rig, reader):
    rig.send("&&\r\n01163.25\r\n011812.5\r\n!!\r\n")
    _until(lambda: not reader.checked()[WOB].fault)
    assert reader.checked()[WOB].value == pytest.approx(32500.0)
    assert reader.checked()[TORQUE].value == pytest.approx(12500.0)
    rig.send("&&\r\n0116-999.25\r\n0118x\r\n!!\r\n")
    _until(lambda: reader.checked()[TORQUE].fault)
    assert reader.checked()[WOB].fault == "-999.25 stands for no value"
    assert reader.left_out()["weight_on_bit"].endswith("1 x -999.25 stands for no value")
    assert reader.checked()[TORQUE].fault == 'expected a number, found "x"'
    rig.drop()
    _until(lambda: reader.connections == 2)
    rig.send("&&\r\n01165.0\r\n!!\r\n")
    _until(lambda: not reader.checked()[WOB].fault)
    assert reader.checked()[WOB].value == pytest.approx(50000.0)


@pytest.mark.parametrize("text", ["2_0", "infinity", "0x10", "1e", "2,5", "x"])
def test_what_python_alone_takes_for_a_number_is_none(rig, reader, text):
    rig.send(f"&&\r\n0116{text}\r\n011812.5\r\n!!\r\n")
    _until(lambda: not reader.checked()[TORQUE].fault)
    assert reader.checked()[WOB].fault == f'expected a number, found "{text}"'


@pytest.mark.parametrize("text", ["-999.25", "-999.2500", "-9999", "-9999.0", "-9999.00", "-8888.000", "-9.999e3"])
def test_no_value_is_known_by_its_number(rig, reader, text):
    rig.send(f"&&\r\n0116{text}\r\n011812.5\r\n!!\r\n")
    _until(lambda: not reader.checked()[TORQUE].fault)
    assert reader.checked()[WOB].fault.endswith("stands for no value")


@pytest.mark.parametrize("text", ["NaN", "inf", "#N/A", "No Data", "1.#QNAN", "null"])
def test_a_word_of_the_trade_is_no_value(rig, reader, text):
    rig.send(f"&&\r\n0116{text}\r\n011812.5\r\n!!\r\n")
    _until(lambda: not reader.checked()[TORQUE].fault)
    assert reader.checked()[WOB].fault == "expected a finite number, found nan"


def test_what_is_no_wits_is_told(rig, reader):
    rig.send("x" * 2000)
    _until(lambda: "expected lines of WITS" in reader.fault)
    assert reader.checked()[WOB].fault.startswith("no connection: expected lines of WITS")
