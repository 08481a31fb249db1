#include "tests/support/run/bench_run.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "drivers/commissioned/record.hpp"
#include "tests/support/devices/mock_cameras.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"

namespace shaker::test {

namespace {

mock::MockBenchSettings settings_for(const std::filesystem::path& folder, double dac_ppm,
                                     const std::string& changes, bool line_input, int channels) {
    if (const std::string refused = private_network(); !refused.empty()) throw std::runtime_error{refused};
    mock::MockBenchSettings s;
    s.scene = simulated::parse_scene(
        test::file_text(test::source_dir() + "/tests/support/slow_cameras.toml") + changes, "test");
    s.folder = folder;
    s.plugin = test::build_dir() + "/shaker_mock_pcm.so";
    s.dac_ppm = dac_ppm;
    s.log_codes = true;
    s.line_input = line_input;
    s.channels = channels;
    return s;
}

}  // namespace

BenchRun::BenchRun(double dac_ppm, const std::string& changes, bool line_input, int channels)
    : folder{fresh_folder()}, bench{settings_for(folder, dac_ppm, changes, line_input, channels)} {}

BenchRun::~BenchRun() {
    program_.reset();
    std::error_code ignored;
    std::filesystem::remove_all(folder, ignored);
}

void BenchRun::rig(const std::string& key, const std::string& value) {
    std::string text = test::file_text(bench.rig_file());
    const auto at = text.find("\n" + key + " = ");
    ASSERT_NE(at, std::string::npos) << key;
    const auto from = at + key.size() + 4;
    text.replace(from, text.find('\n', from) - from, value);
    std::ofstream{bench.rig_file()} << text;
    if (auto record = commissioned::read_record(bench.rig_file())) {
        record->rig_sha256 = commissioned::rig_hash(text);
        commissioned::write_record(bench.rig_file(), *record);
    }
}

void BenchRun::start(const std::string& options) {
    program_ = std::make_unique<Program>(
        "shakerd", "run --json --rig '" + bench.rig_file().string() + "' " + options, folder);
}

bool BenchRun::played(double seconds) {
    const double rate_hz = 48000;
    for (;;) {
        const auto starts = bench.dac().stream_starts();
        if (!starts.empty() && static_cast<double>(bench.dac().taken() - starts.back()) > seconds * rate_hz)
            return true;
        if (program_->ended()) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds{2});
    }
}

Outcome BenchRun::finish() { return program_->wait(60); }

nlohmann::json BenchRun::results() {
    const Outcome o = finish();
    EXPECT_EQ(o.status, 0) << end_of(o.err);
    return o.status == 0 ? nlohmann::json::parse(o.out) : nlohmann::json::object();
}

void expect_order(const Outcome& o) {
    EXPECT_TRUE(o.status == 0 || o.status == 2 || o.status == 3 || o.status == 5) << o.status << "\n"
                                                                                  << end_of(o.err);
    EXPECT_EQ(o.err.find("Sanitizer"), std::string::npos) << o.err;
}

std::string end_of(const std::string& text) {
    constexpr std::size_t most = 2000;
    return text.size() <= most ? text : "..." + text.substr(text.size() - most);
}

nlohmann::json device(const nlohmann::json& results, const std::string& name) {
    for (const auto& d : results.at("devices"))
        if (d.at("device").get<std::string>().find(name) != std::string::npos) return d;
    ADD_FAILURE() << "no device " << name << " in " << results.at("devices");
    return {};
}

bool noted(const nlohmann::json& results, const std::string& words) {
    for (const auto& note : results.at("notes"))
        if (note.get<std::string>().find(words) != std::string::npos) return true;
    return false;
}

}  // namespace shaker::test
