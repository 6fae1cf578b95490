# find_package(scotty COMPONENTS kernels): scotty::kernels, which kernel programs link, scotty::capture, the header with which
# programs write captures, and scotty_add_kernel_program(). The installed tree may be moved.
get_filename_component(scotty_prefix ${CMAKE_CURRENT_LIST_DIR}/../../.. ABSOLUTE)
foreach(component ${scotty_FIND_COMPONENTS})
    set(scotty_${component}_FOUND FALSE)
    if(component MATCHES "^(kernels|capture)$")
        set(scotty_${component}_FOUND TRUE)
    elseif(scotty_FIND_REQUIRED_${component})
        set(scotty_FOUND FALSE)
        set(scotty_NOT_FOUND_MESSAGE "scotty has the components kernels and capture, but no '${component}'")
        return()
    endif()
endforeach()

set(SCOTTY_KERNELS_FOLDER ${scotty_prefix}/lib/cuda-scotty)
if(NOT TARGET scotty_kernels)
    add_library(scotty_kernels SHARED IMPORTED)
    set_target_properties(scotty_kernels PROPERTIES IMPORTED_LOCATION ${SCOTTY_KERNELS_FOLDER}/libscotty-kernels.so
                          IMPORTED_NO_SONAME TRUE INTERFACE_INCLUDE_DIRECTORIES ${scotty_prefix}/include)
endif()
include(${CMAKE_CURRENT_LIST_DIR}/scotty_kernels.cmake)
