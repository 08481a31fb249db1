#pragma once
// The whole program against the mock bench: real libasound, libiio and Aravis on both sides.
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "drivers/mock/bench.hpp"
#include "tests/support/program.hpp"

namespace shaker::test {

/// A bench of its own for one test, in the test's private network. Cameras take 200 pictures a second, which
/// this kind of machine renders beside everything else.
class BenchRun {
public:
    /// `changes`: to the scene, as TOML (see README).
    explicit BenchRun(double dac_ppm = 0, const std::string& changes = {});
    ~BenchRun();
    BenchRun(const BenchRun&) = delete;
    BenchRun& operator=(const BenchRun&) = delete;

    /// Starts `shakerd run` on the bench with these options, besides --rig and --json.
    /// Changes a line of the rig file: `key` = `value`. Before start().
    void rig(const std::string& key, const std::string& value);
    void start(const std::string& options);
    /// Waits until the newest stream has played so many seconds; false when the program ended before.
    bool played(double seconds);
    /// The end of the program: within a minute, else it is killed.
    Outcome finish();
    /// The running program.
    [[nodiscard]] Program& program() { return *program_; }
    /// Results of a program that ended well; an empty object otherwise, with a test failure.
    nlohmann::json results();

    std::filesystem::path folder;
    Bench bench;

private:
    std::unique_ptr<Program> program_;
};

/// It ended well, or gave up in good order for want of data or of a device, and no sanitiser had anything to
/// say.
void expect_order(const Outcome& outcome);

/// The last lines of what a program said.
std::string end_of(const std::string& text);
/// Counts of one device in the results, found by a part of its name.
nlohmann::json device(const nlohmann::json& results, const std::string& name);
/// Whether a note in the results holds these words.
bool noted(const nlohmann::json& results, const std::string& words);

}  // namespace shaker::test
