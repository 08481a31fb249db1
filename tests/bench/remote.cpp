// Round trips per second by lxi-tools and by a plain client, and jitter of the drive with and without them.
//   --seconds S (10) per load   --scene FILE (tests/support/slow_cameras.toml)
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "daemon/acquisition/time_histogram.hpp"
#include "tests/bench/option.hpp"
#include "tests/bench/table.hpp"
#include "tests/support/remote/served_bench.hpp"

namespace {

using namespace shaker;
using Clock = std::chrono::steady_clock;

double since(Clock::time_point begin) { return std::chrono::duration<double>{Clock::now() - begin}.count(); }

/// Counts of the histogram in /metrics, not cumulative, and the largest deviation.
acquisition::PeriodJitter::Seen jitter(int port) {
    test::TcpClient client{port};
    client.send_bytes("GET /metrics HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
    std::istringstream text{client.rest()};
    acquisition::PeriodJitter::Seen seen;
    std::uint64_t below = 0;
    std::size_t bin = 0;
    for (std::string line; std::getline(text, line);) {
        if (!line.starts_with("shakerd_output_period_jitter_seconds_bucket") || bin == seen.counts.size())
            continue;
        const std::uint64_t count = std::stoull(line.substr(line.rfind(' ')));
        seen.counts[bin++] = count - below;
        below = count;
    }
    return seen;
}

acquisition::PeriodJitter::Seen minus(acquisition::PeriodJitter::Seen late,
                                      const acquisition::PeriodJitter::Seen& early) {
    for (std::size_t i = 0; i < late.counts.size(); ++i) late.counts[i] -= early.counts[i];
    return late;
}

/// Round trips per second reported by `lxi benchmark`; 0 if it failed.
double by_lxi(int port, int requests) {
    const std::string command = "lxi benchmark --raw --address 127.0.0.1 --port " + std::to_string(port) +
                                " --count " + std::to_string(requests) + " 2>&1";
    FILE* out = popen(command.c_str(), "r");
    if (out == nullptr) return 0;
    std::string said;
    std::array<char, 256> piece{};
    while (std::fgets(piece.data(), piece.size(), out) != nullptr) said += piece.data();
    pclose(out);
    const auto at = said.find("Result:");
    return at == std::string::npos ? 0 : std::atof(said.c_str() + at + 7);
}

double by_plain_client(int port, double seconds) {
    test::TcpClient client{port};
    const auto begin = Clock::now();
    double n = 0;
    while (since(begin) < seconds) {
        if (client.ask("*IDN?").empty()) return 0;
        ++n;
    }
    return n / since(begin);
}

/// A page with state and all streams: messages are read and discarded.
class Viewer {
public:
    explicit Viewer(int port) : client_{port} {
        client_.send_bytes(
            "GET /ws HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n");
        static_cast<void>(client_.until("\r\n\r\n"));
        for (const char* stream : {"acceleration", "waveform", "cycle", "track", "camera:top", "camera:side"})
            send(std::string{R"({"type":"subscribe","stream":")"} + stream +
                 R"(","width":800,"rate_hz":20})");
        reader_ = std::jthread{[this](const std::stop_token& stop) {
            while (!stop.stop_requested()) bytes_ += client_.some().size();
        }};
    }

private:
    void send(const std::string& text) {  // one frame, masked with zeros
        std::string frame{'\x81', static_cast<char>(0x80 | 126), static_cast<char>(text.size() >> 8),
                          static_cast<char>(text.size() & 0xff)};
        client_.send_bytes(frame + std::string(4, '\0') + text);
    }
    test::TcpClient client_;
    std::size_t bytes_ = 0;
    std::jthread reader_;
};

void add(bench::Table& table, const std::string& load, double rate,
         const acquisition::PeriodJitter::Seen& seen) {
    std::uint64_t periods = 0, beyond = 0;
    for (std::size_t i = 0; i < seen.counts.size(); ++i) {
        periods += seen.counts[i];
        if (i >= acquisition::PeriodJitter::ends_s.size() || acquisition::PeriodJitter::ends_s[i] > 5e-3)
            beyond += seen.counts[i];
    }
    table.add({{"load", load},
               {"round trips", rate, "/s", 4},
               {"drive periods", static_cast<double>(periods), "blocks", 6},
               {"off by, median <=", 1e6 * acquisition::PeriodJitter::quantile(seen, 0.5), "us"},
               {"99 % <=", 1e6 * acquisition::PeriodJitter::quantile(seen, 0.99), "us"},
               {"99.9 % <=", 1e6 * acquisition::PeriodJitter::quantile(seen, 0.999), "us"},
               {"beyond a block", static_cast<double>(beyond), "blocks"},
               {"conditions",
                "simulated rig paced by the clock, blocks of 5 ms, driven; clients on the same machine"}});
}

}  // namespace

int main(int argc, char** argv) {
    const int seconds = bench::whole_option(argc, argv, "--seconds", 10, 1);
    test::ServedBench bench{"phi_rad = 1.5708\ngamma_mps2 = 3\nperiods = 20\n",
                            bench::own_folder(argc, argv, "shakerd-remote")};
    test::TcpClient control{bench.scpi_port()};
    control.send("OUTP ON");
    if (!bench.becomes("run")) return 1;
    bench::Table table;
    const auto measured = [&](const std::string& load, auto run) {
        const acquisition::PeriodJitter::Seen before = jitter(bench.http_port());
        const double rate = run();
        add(table, load, rate, minus(jitter(bench.http_port()), before));
    };
    const auto idle = [&] {
        std::this_thread::sleep_for(std::chrono::seconds{seconds});
        return NAN;
    };
    measured("none", idle);
    measured("lxi benchmark --raw", [&] { return by_lxi(bench.scpi_port(), 20000 * seconds); });
    measured("a plain client", [&] { return by_plain_client(bench.scpi_port(), seconds); });
    {
        std::vector<std::unique_ptr<Viewer>> viewers;
        for (int i = 0; i < 4; ++i) viewers.push_back(std::make_unique<Viewer>(bench.http_port()));
        measured("4 pages with all streams at 20 Hz", idle);
    }
    measured("none again", idle);
    control.send("OUTP OFF");
    table.print(argc, argv);
    return bench.becomes("idle") ? 0 : 1;
}
