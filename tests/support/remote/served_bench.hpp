#pragma once
// The daemon as a user starts it, on the simulated bench and on free ports.
#include <filesystem>
#include <memory>
#include <string>

#include "tests/support/program.hpp"
#include "tests/support/remote/tcp_client.hpp"

namespace shaker::test {

class ServedBench {
public:
    /// Starts it and waits until it serves; `run`: lines of its table [run]. A walker that drifts slowly,
    /// cameras of 200 pictures a second.
    explicit ServedBench(const std::string& run = "phi_rad = 1.745\nperiods = 10\n",
                         std::filesystem::path in = fresh_folder());

    /// Writes the settings file again.
    void settings(const std::string& run, const std::string& serve = {}) const;
    [[nodiscard]] Program& program() { return *program_; }
    [[nodiscard]] int http_port() const noexcept { return http_port_; }
    [[nodiscard]] int scpi_port() const noexcept { return scpi_port_; }
    /// The log so far.
    [[nodiscard]] std::string log() const;
    /// Waits until the log contains this; false after `limit_s`.
    [[nodiscard]] bool logged(const std::string& words, double limit_s = 20) const;
    /// Repeats SYSTem:STATe? until it returns this state; false after `limit_s`.
    [[nodiscard]] bool becomes(const std::string& state, double limit_s = 30) const;

    std::filesystem::path folder;

private:
    std::unique_ptr<Program> program_;
    int http_port_ = 0, scpi_port_ = 0;
};

}  // namespace shaker::test
