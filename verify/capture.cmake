# scotty_capture: captures, pipeline inputs and ray files. It must build with no more than the headers of fmt,
# nlohmann-json, xxHash and GLM, because the self-contained scotty-gpu links it: no Embree, OpenImageIO or TBB.
set(SCOTTY_CAPTURE_SOURCES
    canonical.cpp capture.cpp capture_format.cpp capture_json.cpp capture_writer.cpp failure.cpp npy.cpp
    pipeline_input.cpp ray_file.cpp replay_inputs.cpp)
list(TRANSFORM SCOTTY_CAPTURE_SOURCES PREPEND ${CMAKE_CURRENT_LIST_DIR}/)

scotty_library(capture ${SCOTTY_CAPTURE_SOURCES})
scotty_unity(scotty_capture)
target_link_libraries(scotty_capture PUBLIC scotty::records nlohmann_json::nlohmann_json
                      PRIVATE fmt::fmt-header-only)
