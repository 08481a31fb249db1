#include "daemon/commands/serve_settings.hpp"

#include <spdlog/spdlog.h>
#include <sys/stat.h>

#include <cstdlib>
#include <fstream>
#include <system_error>

#include "daemon/report/installed.hpp"
#include "drivers/errors.hpp"
#include "drivers/settings_table.hpp"

namespace shaker::commands {

namespace {

constexpr int most_port = 65535;
constexpr std::size_t shortest_token = 22;  // 128 bits as base 64
// Settings of older packages name this folder of theirs; without it they mean the program's own page.
constexpr const char* page_of_old_packages = "/usr/share/shakerd/panel";

bool own_machine_only(const std::string& address) { return address.starts_with("127.") || address == "::1"; }

std::string token_of(const std::filesystem::path& file) {
    struct stat facts {};
    if (::stat(file.c_str(), &facts) != 0)
        throw InputError{"token_file " + file.string() + ": there is no such file"};
    if ((facts.st_mode & (S_IRWXG | S_IRWXO)) != 0)
        throw InputError{fmt::format("token_file {}: other users may use it (mode {:o}); expected mode 600",
                                     file.string(), facts.st_mode & 0777U)};
    std::string token;
    std::ifstream{file} >> token;
    if (token.size() < shortest_token)
        throw InputError{fmt::format("token_file {}: {} characters; expected at least {}", file.string(),
                                     token.size(), shortest_token)};
    return token;
}

std::filesystem::path path_at(SettingsTable& table, const char* key, const std::filesystem::path& otherwise) {
    return table.has(key) ? table.folder() / table.text(key) : otherwise;
}

// Where the service manager keeps files of the running service; empty without one.
std::filesystem::path socket_of_service() {
    const char* folder = std::getenv("RUNTIME_DIRECTORY");
    return folder == nullptr ? std::filesystem::path{} : std::filesystem::path{folder} / "scpi";
}

std::filesystem::path socket_at(SettingsTable& table, const std::filesystem::path& otherwise) {
    if (!table.has("scpi_socket")) return otherwise;
    const std::string name = table.text("scpi_socket");
    return name.empty() ? std::filesystem::path{} : table.folder() / name;
}

std::filesystem::path page_at(SettingsTable& table) {
    std::filesystem::path folder = path_at(table, "page", {});
    std::error_code ignored;
    if (folder.empty() || std::filesystem::is_directory(folder, ignored)) return folder;
    if (folder != page_of_old_packages)
        table.fail("page", "\"" + folder.string() + "\": there is no such folder");
    spdlog::info("page {}: there is no such folder; the program's own page is served", folder.string());
    return {};
}

void read_serve_table(SettingsTable table, ServeSettings& s) {
    remote::ServerSettings& server = s.server;
    server.address = table.text("address", server.address);
    server.http_port = table.integer("http_port", 0, most_port, server.http_port);
    server.scpi_port = table.integer("scpi_port", 0, most_port, server.scpi_port);
    server.scpi_socket = socket_at(table, server.scpi_socket);
    if (table.has("host")) server.hosts.push_back(table.text("host"));
    server.page = page_at(table);
    s.recordings = path_at(table, "recordings", s.recordings);
    s.plans = path_at(table, "plans", s.plans);
    s.longest_recording_s = table.number("longest_recording_s", {1, 86400}, s.longest_recording_s);
    if (table.has("token_file")) {
        const std::string token = token_of(table.folder() / table.text("token_file"));
        server.token.assign(token.data(), token.size());  // g++ 12 warns of a move that overlaps nothing
    }
    if (!own_machine_only(server.address) && server.token.empty())
        table.fail("address",
                   "\"" + server.address +
                       "\" is reached from other machines, over HTTP and SCPI; token_file is required");
    if (table.has("mu")) s.mu = {table.number("mu", {0, 10}), table.number("mu_se", {0, 1}, 0)};
    table.finish();
}

}  // namespace

ServeSettings serve_settings(const ServeOptions& options) {
    ServeSettings s;
    s.server.scpi_socket = socket_of_service();
    s.plans = report::installed("plans");
    if (!options.settings.empty()) {
        SettingsTable root = SettingsTable::from_file(options.settings);
        if (root.has("run")) read_run_table(root.table("run"), s.run);
        if (root.has("serve")) read_serve_table(root.table("serve"), s);
        root.finish();
    }
    if (!options.rig.empty()) s.run.rig = options.rig;
    if (!options.scene.empty()) s.run.scene = options.scene;
    if (options.http_port >= 0) s.server.http_port = options.http_port;
    if (options.scpi_port >= 0) s.server.scpi_port = options.scpi_port;
    if (!options.page.empty()) s.server.page = options.page;
    if (!options.recordings.empty()) s.recordings = options.recordings;
    if (!std::filesystem::is_directory(s.recordings))
        throw InputError{"recordings " + s.recordings.string() + ": there is no such folder"};
    return s;
}

}  // namespace shaker::commands
