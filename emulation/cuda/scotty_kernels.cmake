# scotty_add_kernel_program(NAME SOURCES...): a program whose CUDA kernels run on the CPU and are checked while they do.
#
# Files that end in .cu are CUDA text: kernels, launches, device memory. All others are compiled as everywhere, and cannot
# launch. What goes wrong in a kernel is written to standard error when the program ends, and its exit code is 1; a test
# asks scotty::kernels::take_findings() (scotty/kernels.h). Include folders, definitions and CXX_STANDARD are the target's.
if(NOT TARGET scotty::kernels)
    add_library(scotty::kernels ALIAS scotty_kernels)
endif()
if(NOT TARGET scotty::capture_header)
    add_library(scotty_capture_header INTERFACE)
    get_filename_component(scotty_include ${SCOTTY_KERNELS_FOLDER}/../../include ABSOLUTE)
    target_include_directories(scotty_capture_header INTERFACE ${scotty_include})
    target_compile_features(scotty_capture_header INTERFACE cxx_std_17)
    add_library(scotty::capture_header ALIAS scotty_capture_header)
endif()
set_property(GLOBAL PROPERTY SCOTTY_KERNELS_FOLDER ${SCOTTY_KERNELS_FOLDER})

function(scotty_add_kernel_program name)
    get_property(folder GLOBAL PROPERTY SCOTTY_KERNELS_FOLDER)
    set(compile ${folder}/scotty-cuda-cxx)
    set(needed ${compile})
    if(TARGET scotty_cuda_cxx)
        set(needed scotty_cuda_cxx)
    endif()
    set(sources "")
    foreach(source ${ARGN})
        get_filename_component(path ${source} ABSOLUTE)
        if(NOT source MATCHES "\\.cu$")
            list(APPEND sources ${path})
            continue()
        endif()
        string(MAKE_C_IDENTIFIER "${source}" id)
        set(object ${CMAKE_CURRENT_BINARY_DIR}/CMakeFiles/${name}.kernels/${id}.o)
        file(MAKE_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}/CMakeFiles/${name}.kernels)
        set(folders "$<TARGET_PROPERTY:${name},INCLUDE_DIRECTORIES>")
        set(definitions "$<TARGET_PROPERTY:${name},COMPILE_DEFINITIONS>")
        set(standard "$<TARGET_PROPERTY:${name},CXX_STANDARD>")
        add_custom_command(OUTPUT ${object}
            COMMAND ${compile} --compiler ${CMAKE_CXX_COMPILER} -c ${path} -o ${object} -MF ${object}.d
                    "-std=c++$<IF:$<BOOL:${standard}>,${standard},17>"
                    "$<$<BOOL:${folders}>:-I$<JOIN:${folders},;-I>>"
                    "$<$<BOOL:${definitions}>:-D$<JOIN:${definitions},;-D>>"
            DEPENDS ${path} ${needed} DEPFILE ${object}.d COMMAND_EXPAND_LISTS VERBATIM
            COMMENT "Building CUDA text ${source} for the CPU")
        list(APPEND sources ${object})
    endforeach()
    add_executable(${name} ${sources})
    set_target_properties(${name} PROPERTIES LINKER_LANGUAGE CXX)
    target_link_libraries(${name} PRIVATE scotty::kernels scotty::capture_header)
    foreach(call memcpy memmove memset malloc free _Znwm _Znam _ZdlPv _ZdaPv _ZdlPvm _ZdaPvm __assert_fail)
        target_link_options(${name} PRIVATE "LINKER:--wrap=${call}")
    endforeach()
endfunction()
