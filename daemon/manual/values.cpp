#include "daemon/manual/values.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <stdexcept>

#include "drivers/errors.hpp"

namespace shaker::manual {

namespace {

int whole_number(const Argument& a, const std::string& text) {
    long long n = 0;
    const char* const last = text.data() + text.size();
    const auto [end, error] = std::from_chars(text.data(), last, n);
    const bool fits = error == std::errc{} && end == last && static_cast<double>(n) >= a.allowed.min &&
                      static_cast<double>(n) <= a.allowed.max;
    if (!fits)
        throw InputError{fmt::format("{} \"{}\": expected a whole number from {:.0f} to {:.0f}", a.name, text,
                                     a.allowed.min, a.allowed.max)};
    return static_cast<int>(n);
}

void require_word(const Argument& a, const std::string& text) {
    if (std::ranges::find(a.words, text) == a.words.end())
        throw InputError{
            fmt::format("{} \"{}\": expected one of {}", a.name, text, fmt::join(a.words, ", "))};
}

void require_present(const Argument& a, const std::string& text) {
    std::error_code ignored;
    if (a.kind == Kind::folder && !std::filesystem::is_directory(text, ignored))
        throw InputError{fmt::format("{} \"{}\": there is no such folder", a.name, text)};
    if (!std::filesystem::exists(text, ignored) ||
        (a.kind == Kind::file && std::filesystem::is_directory(text, ignored)))
        throw InputError{fmt::format("{} \"{}\": there is no such file", a.name, text)};
}

void require_allowed(const Argument& a, const std::string& text) {
    if (a.kind == Kind::whole) whole_number(a, text);
    if (a.kind == Kind::quantity) parse_quantity(a.name, text, a.dimension, a.allowed);
    if (a.kind == Kind::word) require_word(a, text);
    if (a.must_exist) require_present(a, text);
}

}  // namespace

void Values::add(const Argument& argument, std::vector<std::string> texts) {
    for (const std::string& text : texts) require_allowed(argument, text);
    given_[std::string{argument.name}] = std::move(texts);
}

const Argument& Values::argument(std::string_view name) const {
    for (const std::span<const Argument> all : {command_->arguments, program_->common}) {
        const auto found = std::ranges::find(all, name, &Argument::name);
        if (found != all.end()) return *found;
    }
    throw std::logic_error{fmt::format("command {} has no argument {}", command_->name, name)};
}

bool Values::has(std::string_view name) const { return given_.contains(argument(name).name); }

std::vector<std::string> Values::texts(std::string_view name) const {
    const Argument& a = argument(name);
    if (const auto found = given_.find(a.name); found != given_.end()) return found->second;
    return a.standard.empty() ? std::vector<std::string>{} : std::vector{std::string{a.standard}};
}

std::string Values::text(std::string_view name) const {
    const std::vector<std::string> all = texts(name);
    return all.empty() ? std::string{} : all.front();
}

double Values::number(std::string_view name) const {
    const Argument& a = argument(name);
    return parse_quantity(a.name, text(name), a.dimension, a.allowed);
}

int Values::whole(std::string_view name) const { return whole_number(argument(name), text(name)); }

std::string doubtful_gamma(const Values& values) {
    constexpr double doubtful = 0.2 * paper_g;  // m/s^2
    if (!values.has("--gamma")) return {};
    const std::string text = values.text("--gamma");
    const double gamma = values.number("--gamma");
    if (gamma >= doubtful || text.find_first_not_of("+.,0123456789e-") != std::string::npos) return {};
    return fmt::format(
        "gamma {0} m/s^2 is {1:.3g} g; few walkers move at so little. A number without a unit is in m/s^2; "
        "for {0} g give --gamma {0}g",
        text, gamma / paper_g);
}

Drive changed_drive(const Values& values, Drive drive) {
    const auto change = [&](const char* option, double& x) {
        if (values.has(option)) x = values.number(option);
    };
    change("--gamma", drive.gamma);
    change("--phi", drive.phi);
    change("--rho", drive.rho);
    change("--frequency", drive.frequency);
    return drive;
}

}  // namespace shaker::manual
