#include "tests/support/bench_run.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "tests/support/mock_cameras.hpp"

namespace shaker::test {

namespace {

BenchSettings settings_for(const std::filesystem::path& folder, double dac_ppm, const std::string& changes) {
    if (const std::string refused = private_network(); !refused.empty()) throw std::runtime_error{refused};
    BenchSettings s;
    s.scene = parse_scene("[top]\nframe_rate_hz = 200\n[side]\nframe_rate_hz = 200\n" + changes, "test");
    s.folder = folder;
    s.plugin = SHAKER_BINARY_DIR "/shaker_mock_pcm.so";
    s.dac_ppm = dac_ppm;
    s.log_codes = true;
    return s;
}

}  // namespace

BenchRun::BenchRun(double dac_ppm, const std::string& changes)
    : folder{fresh_folder()}, bench{settings_for(folder, dac_ppm, changes)} {}

BenchRun::~BenchRun() {
    program_.reset();
    std::error_code ignored;
    std::filesystem::remove_all(folder, ignored);
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
