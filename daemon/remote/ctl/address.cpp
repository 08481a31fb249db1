#include "daemon/remote/ctl/address.hpp"

#include <spdlog/fmt/fmt.h>
#include <sys/stat.h>

#include <algorithm>
#include <charconv>
#include <fstream>

#include "drivers/errors.hpp"
#include "drivers/text/printable.hpp"

namespace shaker::ctl {

namespace {

constexpr const char* default_port = "8080";
constexpr int most_port = 65535;

bool of_a_name(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '-' || c == '_';
}

bool of_a_number(char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F') || c == ':' || c == '.';
}

bool is_port(std::string_view text) {
    int port = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
    return error == std::errc{} && end == text.data() + text.size() && port >= 1 && port <= most_port;
}

}  // namespace

std::string Address::text() const {
    const bool number = host.find(':') != std::string::npos;
    return (number ? "[" + host + "]" : host) + ":" + port;
}

Address address_of(std::string_view what, std::string_view url) {
    const auto refuse = [&](const std::string& why) {
        return InputError{fmt::format("{} \"{}\": {}; expected an address like {}", what, printable(url), why,
                                      default_url)};
    };
    std::string_view rest = url;
    if (rest.starts_with("https://")) throw refuse("the daemon speaks plain HTTP");
    if (rest.starts_with("http://")) rest.remove_prefix(7);
    if (rest.ends_with('/')) rest.remove_suffix(1);
    const bool bracket = rest.starts_with('[');
    const auto end = bracket ? rest.find(']') : rest.find(':');
    if (bracket && end == std::string_view::npos) throw refuse("a bracket is not closed");
    Address at{std::string{rest.substr(bracket, end == std::string_view::npos ? end : end - bracket)},
               default_port};
    if (at.host.empty() || !std::ranges::all_of(at.host, bracket ? of_a_number : of_a_name))
        throw refuse("host name or address expected");
    rest = end == std::string_view::npos ? std::string_view{} : rest.substr(end + (bracket ? 1 : 0));
    if (rest.empty()) return at;
    if (!rest.starts_with(':') || !is_port(rest.substr(1)))
        throw refuse(fmt::format("port 1 to {} expected after the host", most_port));
    at.port = rest.substr(1);
    return at;
}

std::string token_of_file(const std::filesystem::path& file) {
    struct stat facts {};
    if (::stat(file.c_str(), &facts) != 0)
        throw InputError{"--token-file " + file.string() + ": there is no such file"};
    if ((facts.st_mode & (S_IRWXG | S_IRWXO)) != 0)
        throw InputError{fmt::format("--token-file {}: other users can read it (mode {:o}); set mode 600",
                                     file.string(), facts.st_mode & 0777U)};
    std::string token;
    if (!(std::ifstream{file} >> token))
        throw InputError{"--token-file " + file.string() + ": no token in the file, or it cannot be read"};
    return checked_token("--token-file " + file.string(), token);
}

std::string checked_token(std::string_view what, std::string token) {
    if (!std::ranges::all_of(token, [](char c) { return c > ' ' && c < '\x7f'; }))
        throw InputError{
            fmt::format("{}: a token consists of visible ASCII characters without blanks", what)};
    return token;
}

}  // namespace shaker::ctl
