/// What a picture says of itself, and what lies between two states of a view.
#pragma once

#include <string>

#include "reference/contract/image.h"
#include "verify/view/display.h"
#include "verify/view/render_loop.h"

namespace scotty::verify {

/// The standard error of the mean pixel, as a share of it; 0: not known.
double noise_of(const reference::Image& image);
/// XXH3 of the radiance, as hexadecimal digits.
std::string hash_of(const reference::Image& image);
/// By pixel: the standard error as a share of the mean.
FeatureImage variance_of(const reference::Image& image);

/// Whether the back end runs on the CPU.
bool is_cpu(const std::string& backend);
/// Parameters for which a pipeline has to be made anew.
bool needs_new_pipeline(const ViewState& a, const ViewState& b);
bool needs_new_tree(const reference::PipelineParameters& a, const reference::PipelineParameters& b);
/// "tree width 8 to 4, bounces 2 to 3". Sets `changes_picture` where one of them makes another
/// picture.
std::string differences(const ViewState& a, const ViewState& b, bool& changes_picture);
bool same_camera(const reference::Camera& a, const reference::Camera& b);

}  // namespace scotty::verify
