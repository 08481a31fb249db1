#include "tracking/patch_locator.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace shaker::tracking {
namespace {

constexpr int block = 8;
constexpr double enough_match = 0.6;  // correlation; below it a position does not resemble the texture

// Matrix on the image's own memory, no copy. OpenCV's correlation takes 8 bit and float only.
cv::Mat for_matching(const ImageView& image, const Box& box) {
    const cv::Mat whole_image{image.height, image.width, image.bytes_per_pixel == 2 ? CV_16UC1 : CV_8UC1,
                              const_cast<std::byte*>(image.pixels), static_cast<std::size_t>(image.stride)};
    cv::Mat out;
    whole_image(cv::Rect{box.x0, box.y0, box.x1 - box.x0, box.y1 - box.y0}).convertTo(out, CV_32F);
    return out;
}

cv::Mat template_of(Texture& texture) {
    texture.shift({0, 0});
    cv::Mat1f out(texture.height(), texture.width());
    for (int y = 0; y < texture.height(); ++y) {
        std::transform(texture.value(y), texture.value(y) + texture.width(), out[y],
                       [](double v) { return static_cast<float>(v); });
    }
    return out;
}

}  // namespace

// Products of 1, T, dT/dx, dT/dy and I over the blocks in use, and of the smooth derivatives with those and
// with themselves.
struct PatchLocator::Sums {
    Eigen::Matrix<double, 5, 5> gram = Eigen::Matrix<double, 5, 5>::Zero();
    Eigen::Matrix<double, 2, 7> smooth = Eigen::Matrix<double, 2, 7>::Zero();
};

std::size_t PatchLocator::block_of(int x, int y) const noexcept {
    const int row = y / block, column = x / block;
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(block_columns_) +
           static_cast<std::size_t>(column);
}

template <class P>
void PatchLocator::accumulate(const P& pixels, const Box& cut, int x0, int y0, Sums& sums) const {
    for (int y = cut.y0; y < cut.y1; ++y) {
        const auto* row = pixels.row(y0 + y) + x0;
        const double *t = texture_.value(y), *tx = texture_.dx(y), *ty = texture_.dy(y);
        const double *px = texture_.smooth_dx(y), *py = texture_.smooth_dy(y);
        for (int from = cut.x0; from < cut.x1;) {
            const int to = std::min(cut.x1, (from / block + 1) * block);
            const bool used = block_weight_[block_of(from, y)] > 0;
            for (int x = used ? from : to; x < to; ++x) {
                const Eigen::Matrix<double, 5, 1> c{1, t[x], tx[x], ty[x], static_cast<double>(row[x])};
                sums.gram.noalias() += c * c.transpose();
                const Eigen::Vector2d p{px[x], py[x]};
                sums.smooth.leftCols<5>().noalias() += p * c.transpose();
                sums.smooth.rightCols<2>().noalias() += p * p.transpose();
            }
            from = to;
        }
    }
}

// Excludes blocks with outlying residuals; returns the share of pixels in use.
template <class P>
double PatchLocator::weigh_blocks(const P& pixels, const Box& cut, int x0, int y0, double gain,
                                  double offset) {
    std::fill(block_residual_.begin(), block_residual_.end(), 0.0);
    std::fill(block_size_.begin(), block_size_.end(), 0.0);
    for (int y = cut.y0; y < cut.y1; ++y) {
        const auto* row = pixels.row(y0 + y) + x0;
        const double* t = texture_.value(y);
        for (int x = cut.x0; x < cut.x1; ++x) {
            const double r = static_cast<double>(row[x]) - gain * t[x] - offset;
            const auto b = block_of(x, y);
            block_residual_[b] += r * r;
            block_size_[b] += 1;
        }
    }
    sorted_.clear();
    for (std::size_t b = 0; b < block_size_.size(); ++b) {
        if (block_size_[b] > 0) sorted_.push_back(block_residual_[b] / block_size_[b]);
    }
    const auto middle = sorted_.begin() + static_cast<std::ptrdiff_t>(sorted_.size() / 2);
    std::nth_element(sorted_.begin(), middle, sorted_.end());
    const double limit = 6 * *middle + 0.5;
    double kept = 0;
    for (std::size_t b = 0; b < block_size_.size(); ++b) {
        const bool good = block_size_[b] > 0 && block_residual_[b] <= limit * block_size_[b];
        block_weight_[b] = good ? 1 : 0;
        if (good) kept += block_size_[b];
    }
    return kept / (static_cast<double>(texture_.width()) * texture_.height());
}

PatchLocator::Solution PatchLocator::measure(const ImageView& image, Point shift) {
    Solution s;
    std::fill(block_weight_.begin(), block_weight_.end(), 1.0);
    for (int pass = 0; pass < 8; ++pass) {
        const int nx = static_cast<int>(std::lround(shift.x)), ny = static_cast<int>(std::lround(shift.y));
        const int x0 = texture_.box().x0 + nx, y0 = texture_.box().y0 + ny;
        const Box cut{std::max(0, -x0), std::max(0, -y0), std::min(texture_.width(), image.width - x0),
                      std::min(texture_.height(), image.height - y0)};
        if (cut.x1 - cut.x0 < 4 || cut.y1 - cut.y0 < 4) return s;
        texture_.shift({shift.x - nx, shift.y - ny});
        Sums sums;
        with_pixels(image, [&](auto pixels) { accumulate(pixels, cut, x0, y0, sums); });
        const auto& g = sums.gram;
        const Eigen::Matrix2d basis = g.topLeftCorner<2, 2>();
        const double determinant = basis.determinant();
        if (!(determinant > 1e-6 * basis(0, 0) * basis(1, 1))) return s;
        const Eigen::Matrix<double, 2, 3> solved = basis.inverse() * g.block<2, 3>(0, 2);
        const Eigen::Matrix3d schur = g.block<3, 3>(2, 2) - g.block<3, 2>(2, 0) * solved;
        s.gain = solved(1, 2);
        if (!(s.gain > 0.05)) return s;
        // Score and slope from the smooth derivatives; gain and offset eliminated.
        const auto& p = sums.smooth;
        const Eigen::Matrix<double, 2, 3> weighed = p.block<2, 3>(0, 2) - p.leftCols<2>() * solved;
        const Eigen::Matrix2d slope = -s.gain * weighed.leftCols<2>();
        const Eigen::Matrix2d spread =
            p.rightCols<2>() - p.leftCols<2>() * basis.inverse() * p.leftCols<2>().transpose();
        Eigen::Vector2d step = Eigen::Vector2d::Zero();
        if (one_direction_) {
            const double along = direction_.dot(slope * direction_);
            step = direction_ * direction_.dot(weighed.col(2)) / along;
            s.covariance =
                direction_ * direction_.transpose() * direction_.dot(spread * direction_) / (along * along);
        } else {
            const Eigen::Matrix2d inverse = slope.inverse();
            step = inverse * weighed.col(2);
            s.covariance = inverse * spread * inverse.transpose();
        }
        if (!step.allFinite()) return s;
        const double n = g(0, 0), total = g(4, 4) - g(0, 4) * g(0, 4) / n;
        s.variance = std::max(schur(2, 2), 0.0) / std::max(n - 4, 1.0) + 1e-4;
        s.likeness = std::sqrt(std::clamp(1 - schur(2, 2) / total, 0.0, 1.0));
        if (pass >= 2 && step.norm() < 2e-3) s.converged = true;
        step *= std::min(1.0, 1.5 / std::max(step.norm(), 1e-12));
        shift = shift + Point{step[0], step[1]};
        if (s.converged) break;
        s.share = with_pixels(
            image, [&](auto pixels) { return weigh_blocks(pixels, cut, x0, y0, s.gain, solved(0, 2)); });
        if (step.norm() > 0.5) std::fill(block_weight_.begin(), block_weight_.end(), 1.0);
    }
    s.shift = shift;
    return s;
}

void PatchLocator::find_direction() {
    texture_.shift({0, 0});
    Eigen::Matrix2d structure = Eigen::Matrix2d::Zero();
    for (int y = 0; y < texture_.height(); ++y) {
        for (int x = 0; x < texture_.width(); ++x) {
            const Eigen::Vector2d g{texture_.dx(y)[x], texture_.dy(y)[x]};
            structure += g * g.transpose();
        }
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen{structure};
    one_direction_ = eigen.eigenvalues()[0] < 0.03 * eigen.eigenvalues()[1];
    direction_ = eigen.eigenvectors().col(1);
    const double along = std::abs(direction_[0] * subject_.along[0] + direction_[1] * subject_.along[1]);
    if (one_direction_ && along < 0.5) {
        throw InputError{subject_.label + ": the texture does not vary along the shaker's axis"};
    }
}

// Frame 0 fits itself without residual; its noise is measured with a mask that ignores planes and curvature.
void PatchLocator::find_noise(const ImageView& image) {
    const Box& b = texture_.box();
    double sum = 0, n = 0;
    with_pixels(image, [&](auto p) {
        for (int y = b.y0 + 1; y + 1 < b.y1; ++y) {
            for (int x = b.x0 + 1; x + 1 < b.x1; ++x) {
                const double edges = p.at(x - 1, y) + p.at(x + 1, y) + p.at(x, y - 1) + p.at(x, y + 1);
                const double corners =
                    p.at(x - 1, y - 1) + p.at(x + 1, y - 1) + p.at(x - 1, y + 1) + p.at(x + 1, y + 1);
                sum += std::abs(corners - 2 * edges + 4 * p.at(x, y)) / 6;
                n += 1;
            }
        }
    });
    const double noise = sum / std::max(n, 1.0) * std::sqrt(std::numbers::pi / 2);
    least_variance_ = noise * noise + 1.0 / 12;
}

Point PatchLocator::learn(const ImageView& image) {
    const Box box = region_in(subject_, image);
    levels_in(subject_, image, box);
    texture_ = Texture{image, box};
    learned_ = {0.5 * (box.x0 + box.x1 - 1), 0.5 * (box.y0 + box.y1 - 1)};
    block_columns_ = (texture_.width() + block - 1) / block;
    const auto blocks = static_cast<std::size_t>(block_columns_) *
                        static_cast<std::size_t>((texture_.height() + block - 1) / block);
    block_weight_.assign(blocks, 1.0);
    block_residual_.assign(blocks, 0.0);
    block_size_.assign(blocks, 0.0);
    sorted_.reserve(blocks);
    find_direction();
    find_noise(image);
    return learned_;
}

double PatchLocator::extent() const noexcept { return 0.5 * std::min(texture_.width(), texture_.height()); }

bool PatchLocator::judge(const Solution& s, Candidate& out) const {
    if (!s.converged || s.gain < 0.3 || s.gain > 3 || s.share < 0.3 || s.likeness < enough_match)
        return false;
    const Eigen::Vector2d axis{subject_.along[0], subject_.along[1]};
    // The position of a texture with one direction is known along that direction, which may be oblique to the
    // axis.
    out.sd = std::sqrt(std::max(s.variance, least_variance_) *
                       (one_direction_ ? s.covariance.trace() : axis.dot(s.covariance * axis)));
    out.at = learned_ + s.shift;
    out.likeness = s.likeness * std::min(1.0, s.share);
    out.degraded = s.share < 0.8;
    return out.sd < 0.5;
}

// Whole-pixel position of the best correlation within reach.
bool PatchLocator::best_match(const ImageView& image, Point around, Point& shift) const {
    const int r = static_cast<int>(reach());
    const int x = texture_.box().x0 + static_cast<int>(std::lround(around.x));
    const int y = texture_.box().y0 + static_cast<int>(std::lround(around.y));
    const Box area{std::max(0, x - r), std::max(0, y - r), std::min(image.width, x + texture_.width() + r),
                   std::min(image.height, y + texture_.height() + r)};
    if (area.x1 - area.x0 < texture_.width() || area.y1 - area.y0 < texture_.height()) return false;
    Texture still = texture_;
    cv::Mat score;
    cv::matchTemplate(for_matching(image, area), template_of(still), score, cv::TM_CCOEFF_NORMED);
    double best = 0;
    cv::Point at;
    cv::minMaxLoc(score, nullptr, &best, nullptr, &at);
    shift = {double(area.x0 + at.x - texture_.box().x0), double(area.y0 + at.y - texture_.box().y0)};
    return best > enough_match;
}

bool PatchLocator::locate(const ImageView& image, Point predicted, Candidate& out) {
    const Point start = predicted - learned_;
    if (judge(measure(image, start), out) && length(out.at - predicted) < reach()) return true;
    Point shift;
    return best_match(image, start, shift) && judge(measure(image, shift), out) &&
           length(out.at - predicted) < 1.5 * reach();
}

void PatchLocator::search(const ImageView& image, Point, Sweep, std::vector<Candidate>& out) {
    if (image.width < texture_.width() || image.height < texture_.height()) return;
    cv::Mat1f score;
    cv::matchTemplate(for_matching(image, whole(image)), template_of(texture_), score, cv::TM_CCOEFF_NORMED);
    for (int tries = 0; tries < 24; ++tries) {
        double best = 0;
        cv::Point at;
        cv::minMaxLoc(score, nullptr, &best, nullptr, &at);
        if (!(best > enough_match)) break;
        const int r = std::max(2, static_cast<int>(extent()));
        const cv::Rect near =
            cv::Rect{at.x - r, at.y - r, 2 * r + 1, 2 * r + 1} & cv::Rect{0, 0, score.cols, score.rows};
        score(near).setTo(0);
        Candidate candidate;
        const Point shift{double(at.x - texture_.box().x0), double(at.y - texture_.box().y0)};
        if (!judge(measure(image, shift), candidate)) continue;
        const auto same = [&](const Candidate& c) { return length(c.at - candidate.at) < extent(); };
        if (std::none_of(out.begin(), out.end(), same)) out.push_back(candidate);
    }
}

}  // namespace shaker::tracking
