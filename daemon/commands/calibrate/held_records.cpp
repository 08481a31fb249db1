#include "daemon/commands/calibrate/held_records.hpp"

#include <spdlog/fmt/fmt.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <string_view>

#include "drivers/errors.hpp"

namespace shaker::commands {

namespace {

constexpr std::string_view columns = "attitude,x,y,z";
constexpr std::string_view sensor_comment = "# sensor = ", nominal_comment = "# nominal_mps2_per_count = ";

class HeldReader {
public:
    HeldReader(const std::filesystem::path& file, HeldRecords& into) : file_{file.string()}, into_{into} {}

    void read() {
        std::ifstream in{file_, std::ios::binary};
        if (!in) throw InputError{file_ + ": cannot be read: " + std::strerror(errno)};
        for (std::string line; std::getline(in, line);) {
            ++line_;
            if (line.ends_with('\r')) line.pop_back();
            if (line.empty()) continue;
            if (headed_)
                sample(line);
            else
                head(line);
        }
        if (!headed_) fail(fmt::format("expected the header \"{}\"", columns));
        finish();
    }

private:
    [[noreturn]] void fail(const std::string& why) const {
        throw InputError{fmt::format("{}:{}: {}", file_, line_, why)};
    }

    void head(const std::string& line) {
        if (line.starts_with(sensor_comment)) {
            into_.sensor = line.substr(sensor_comment.size());
        } else if (line.starts_with(nominal_comment)) {
            std::string_view rest = std::string_view{line}.substr(nominal_comment.size());
            for (double& scale : into_.nominal_mps2_per_count)
                scale = field<double>(rest, "a scale in m/s^2");
        } else if (line == columns) {
            headed_ = true;
        } else if (!line.starts_with('#')) {
            fail(fmt::format("expected the header \"{}\", got \"{}\"", columns, line.substr(0, 40)));
        }
    }

    // The next number of a row with commas.
    template <class Number>
    Number field(std::string_view& rest, std::string_view what) const {
        while (rest.starts_with(' ') || rest.starts_with(',')) rest.remove_prefix(1);
        Number value{};
        const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
        if (error != std::errc{} || (end != rest.data() + rest.size() && *end != ',' && *end != ' '))
            fail(fmt::format("expected {}, got \"{}\"", what, rest.substr(0, 40)));
        rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
        return value;
    }

    void sample(const std::string& line) {
        const std::size_t comma = line.find(',');
        const std::string name = line.substr(0, comma);
        if (!name.empty() && !direction_of(name))
            fail(fmt::format(
                "\"{}\" is not an attitude: expected the axes that point up, for example +x or +x-z",
                name.substr(0, 40)));
        if (name != name_) finish();
        name_ = name;
        std::string_view rest = comma == std::string::npos ? "" : std::string_view{line}.substr(comma);
        calibration::Counts& counts = samples_.emplace_back();
        for (std::int32_t& c : counts) c = field<std::int32_t>(rest, "counts, a whole number");
        if (!rest.empty()) fail(fmt::format("expected the columns \"{}\", got more", columns));
    }

    void finish() {
        if (samples_.empty()) return;
        into_.attitudes.push_back(calibration::attitude_of(name_, samples_));
        samples_.clear();
    }

    std::string file_;
    HeldRecords& into_;
    int line_ = 0;
    bool headed_ = false;
    std::string name_;
    std::vector<calibration::Counts> samples_;
};

}  // namespace

HeldRecords read_held(std::span<const std::filesystem::path> files) {
    HeldRecords all;
    for (const std::filesystem::path& file : files) HeldReader{file, all}.read();
    if (all.attitudes.empty()) throw InputError{files.front().string() + ": has no samples"};
    return all;
}

std::string held_header(const HeldRecords& of) {
    return fmt::format("{}{}\n{}{}\n{}\n", sensor_comment, of.sensor, nominal_comment,
                       fmt::join(of.nominal_mps2_per_count, ", "), columns);
}

std::string held_rows(const std::string& attitude, std::span<const calibration::Counts> samples) {
    std::string text;
    for (const calibration::Counts& c : samples)
        text += fmt::format("{},{},{},{}\n", attitude, c[0], c[1], c[2]);
    return text;
}

}  // namespace shaker::commands
