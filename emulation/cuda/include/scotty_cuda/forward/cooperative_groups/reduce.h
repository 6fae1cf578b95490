/// Part of cooperative_groups.h here.
#pragma once

#include "scotty_cuda/forward/cooperative_groups.h"
