#include "tracking/locator.hpp"

#include "drivers/errors.hpp"

namespace shaker::tracking {

std::unique_ptr<Locator> make_locator(const View& view, std::size_t index) {
    Subject subject = subject_of(view, view.targets.at(index));
    switch (subject.target.kind) {
        case TargetKind::disc:
            return make_disc_locator(std::move(subject));
        case TargetKind::rectangle:
            return make_rectangle_locator(std::move(subject));
        case TargetKind::dots:
            if (subject.target.pitch_mm > 0) return make_dots_locator(std::move(subject));
            return make_disc_locator(std::move(subject));
        case TargetKind::bars:
            return make_bars_locator(std::move(subject));
        case TargetKind::code:
            return make_code_locator(std::move(subject));
        case TargetKind::patch:
            return make_patch_locator(std::move(subject));
    }
    throw InputError{subject.label + ": unknown kind"};
}

}  // namespace shaker::tracking
