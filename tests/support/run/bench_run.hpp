#pragma once
// The whole program against the mock bench: real libasound, libiio and Aravis on both sides.
#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "tests/mock/mock_bench.hpp"
#include "tests/support/program.hpp"

namespace shaker::test {

/// A bench for one test, in the private network of the test. Cameras take 200 pictures per second, which a
/// small machine can render beside everything else.
class BenchRun {
public:
    /// `changes`: to the scene, as TOML (drivers/simulated/SCENES.md). line_input, channels: as
    /// MockBenchSettings.
    explicit BenchRun(double dac_ppm = 0, const std::string& changes = {}, bool line_input = false,
                      int channels = 0);
    ~BenchRun();
    BenchRun(const BenchRun&) = delete;
    BenchRun& operator=(const BenchRun&) = delete;

    /// Changes a line of the rig file: `key` = `value`. Before start(). A record of the commissioning then
    /// covers the new file.
    void rig(const std::string& key, const std::string& value);
    /// Starts `shakerd run` on the bench with these options, besides --rig and --json.
    void start(const std::string& options);
    /// Waits until the newest stream has played `s` seconds; false if the program ended before.
    bool played(double seconds);
    /// Waits for the end of the program; kills it after a minute.
    Outcome finish();
    /// The running program.
    [[nodiscard]] Program& program() { return *program_; }
    /// Results of a program that ended with status 0; otherwise an empty object and a test failure.
    nlohmann::json results();

    std::filesystem::path folder;
    mock::MockBench bench;

private:
    std::unique_ptr<Program> program_;
};

/// True if the program ended with status 0, or with a proper error because data or a device were missing, and
/// no sanitiser reported anything.
void expect_order(const Outcome& outcome);

/// The last lines of the output of a program.
std::string end_of(const std::string& text);
/// Counts of one device in the results, by a part of its name.
nlohmann::json device(const nlohmann::json& results, const std::string& name);
/// True if a note in the results contains these words.
bool noted(const nlohmann::json& results, const std::string& words);

}  // namespace shaker::test
