#include "daemon/report/printing.hpp"

#include <spdlog/pattern_formatter.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "drivers/text/printable.hpp"

namespace shaker::report {

namespace {

class Printable final : public spdlog::custom_flag_formatter {
public:
    void format(const spdlog::details::log_msg& message, const std::tm&, spdlog::memory_buf_t& to) override {
        const std::string text = printable({message.payload.data(), message.payload.size()}, true);
        to.append(text.data(), text.data() + text.size());
    }
    [[nodiscard]] std::unique_ptr<custom_flag_formatter> clone() const override {
        return std::make_unique<Printable>();
    }
};

}  // namespace

void say(std::string_view text, std::FILE* to) {
    const std::string safe = printable(text, true);
    std::fwrite(safe.data(), 1, safe.size(), to);
}

std::string json_text(const nlohmann::json& json) {
    return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::unique_ptr<spdlog::formatter> log_format() {
    auto format = std::make_unique<spdlog::pattern_formatter>();
    format->add_flag<Printable>('*').set_pattern("%*");
    return format;
}

}  // namespace shaker::report
