// shaker-mock: a bench of mock devices that speak the real protocols, with faults on command.
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstring>
#include <exception>
#include <iostream>
#include <nlohmann/json.hpp>

#include "drivers/errors.hpp"
#include "drivers/text/printable.hpp"
#include "tests/mock/loopback.hpp"
#include "tests/mock/mock_commands.hpp"

namespace {

using namespace shaker;
using namespace shaker::mock;

constexpr const char* about =
    "shaker-mock plays a whole bench: a DAC for libasound, an accelerometer for libiio and two GigE Vision\n"
    "cameras, all on one simulated shaker. It prints the rig file to give to shakerd, then obeys its "
    "input.\n";

// In memory, so that no disk is between the DAC and its client.
class Folder {
public:
    explicit Folder(const std::filesystem::path& asked) : path_{asked}, ours_{asked.empty()} {
        if (!ours_) {
            std::filesystem::create_directories(path_);
            return;
        }
        const std::filesystem::path memory{"/dev/shm"};
        const auto parent =
            std::filesystem::is_directory(memory) ? memory : std::filesystem::temp_directory_path();
        std::string name = (parent / "shaker-mock-XXXXXX").string();
        if (::mkdtemp(name.data()) == nullptr) throw DeviceError{name + ": " + std::strerror(errno)};
        path_ = name;
    }
    ~Folder() {
        std::error_code ignored;
        if (ours_) std::filesystem::remove_all(path_, ignored);
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }

private:
    std::filesystem::path path_;
    bool ours_;
};

void say(const nlohmann::json& answer) {
    std::cout << answer.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace) << std::endl;
}

void obey(MockBench& bench) {
    for (std::string line; std::getline(std::cin, line);) {
        if (line.find_first_not_of(" \t") == std::string::npos) continue;
        if (line == "quit") return;
        try {
            std::cout << printable(bench_command(bench, line)) << std::endl;
        } catch (const std::exception& e) {
            say({{"ok", false}, {"error", e.what()}});
        }
    }
}

int serve(int argc, char** argv) {
    CLI::App app{about, "shaker-mock"};
    std::filesystem::path scene, folder;
    MockBenchSettings settings;
    app.add_option("--scene", scene,
                   "TOML file that changes the simulated bench (as for shakerd run --scene)");
    app.add_option("--dac-ppm", settings.dac_ppm, "Error of the DAC's clock in ppm; positive: fast")
        ->check(CLI::Range(-1000.0, 1000.0));
    app.add_option("--port", settings.iiod_port, "TCP port of the accelerometer's daemon [any free port]");
    app.add_option("--folder", folder, "Folder of the rig file and its data [a new one in memory]");
    app.add_flag("--log-codes", settings.log_codes,
                 "Write every output sample to the file codes in the folder");
    app.footer("Commands on standard input, answered by a line of JSON each:\n" + bench_help());
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& e) {
        return app.exit(e) == 0 ? 0 : 2;
    }
    if (!scene.empty()) settings.scene = simulated::read_scene(scene);
    const std::array<std::string, 1> second{bench_addresses[1]};
    if (const std::string refused = add_loopback_addresses(second); !refused.empty())
        throw DeviceError{"the loopback interface: " + refused +
                          "; run \"sudo ip address add 127.0.0.2/8 dev lo\", or start shaker-mock and "
                          "shakerd from one \"unshare -rn\" shell"};
    settings.plugin = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "shaker_mock_pcm.so";
    const Folder own{folder};
    settings.folder = own.path();
    MockBench bench{settings};
    say({{"ok", true}, {"rig", bench.rig_file().string()}});
    spdlog::info("the bench is running; try: shakerd check --rig {}", bench.rig_file().string());
    obey(bench);
    return 0;
}

}  // namespace

int main(int argc, char** argv) try {
    spdlog::set_default_logger(spdlog::stderr_color_mt("shaker-mock"));
    spdlog::set_pattern("%v");
    return serve(argc, argv);
} catch (const shaker::InputError& e) {
    spdlog::error("shaker-mock: {}", e.what());
    return 2;
} catch (const std::exception& e) {
    spdlog::error("shaker-mock: {}", e.what());
    return 3;
}
