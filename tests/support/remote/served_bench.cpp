#include "tests/support/remote/served_bench.hpp"

#include <chrono>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <thread>
#include <utility>

#include "tests/support/paths.hpp"

namespace shaker::test {

namespace {

template <class Condition>
bool soon(double limit_s, Condition condition) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>{limit_s};
    while (!condition()) {
        if (std::chrono::steady_clock::now() > end) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds{20});
    }
    return true;
}

}  // namespace

ServedBench::ServedBench(const std::string& run, std::filesystem::path in) : folder{std::move(in)} {
    settings(run);
    program_ = std::make_unique<Program>(
        "shakerd",
        "serve --settings settings.toml --http-port 0 --scpi-port 0 --recordings . --scene "
        "'" +
            test::source_dir() + "/tests/support/slow_cameras.toml'",
        folder);
    const bool up = soon(30, [&] {
        const std::string said = log();
        const auto at = said.find("page and metrics: ");
        return at != std::string::npos &&
               std::sscanf(said.c_str() + at,
                           "page and metrics: http://127.0.0.1:%d/ instrument language: 127.0.0.1 port %d",
                           &http_port_, &scpi_port_) == 2;
    });
    if (!up || !becomes("idle")) throw std::runtime_error{"the daemon did not come up: " + log()};
}

void ServedBench::settings(const std::string& run, const std::string& serve) const {
    std::ofstream{folder / "settings.toml"} << "[run]\n" << run << "[serve]\n" << serve;
}

std::string ServedBench::log() const {
    std::ifstream in{program_->said()};
    return {std::istreambuf_iterator<char>{in}, {}};
}

bool ServedBench::logged(const std::string& words, double limit_s) const {
    return soon(limit_s, [&] { return log().find(words) != std::string::npos; });
}

bool ServedBench::becomes(const std::string& state, double limit_s) const {
    TcpClient client{scpi_port_};
    return soon(limit_s, [&] { return client.ask("SYST:STAT?") == '"' + state + '"'; });
}

}  // namespace shaker::test
