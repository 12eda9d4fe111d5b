/* The calls of MPI that a run needs. They are in C because its types and constants differ between its makers. */

#include <mpi.h>
#include <stddef.h>

/* Enters; 0, or 1 if that fails, or 2 if this MPI may not be called by the threads of a process in turn. */
int dotyk_mpi_begin(int *rank, int *size, int *neighbours)
{
    int level;
    MPI_Comm host;
    if (MPI_Init_thread(NULL, NULL, MPI_THREAD_SERIALIZED, &level) != MPI_SUCCESS) return 1;
    if (level < MPI_THREAD_SERIALIZED) return 2;
    MPI_Comm_rank(MPI_COMM_WORLD, rank);
    MPI_Comm_size(MPI_COMM_WORLD, size);
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &host);
    MPI_Comm_size(host, neighbours);
    MPI_Comm_free(&host);
    return 0;
}

/* Three numbers of all processes; errors end the program. */
void dotyk_mpi_heads(const long long *own, long long *all)
{
    MPI_Allgather(own, 3, MPI_LONG_LONG, all, 3, MPI_LONG_LONG, MPI_COMM_WORLD);
}

/* The parts of all processes, of these counts and at these places. */
void dotyk_mpi_gather(const double *own, double *all, const int *counts, const int *places, int rank)
{
    MPI_Allgatherv(own, counts[rank], MPI_DOUBLE, all, counts, places, MPI_DOUBLE, MPI_COMM_WORLD);
}

/* Leaves, when all do. */
void dotyk_mpi_end(void)
{
    MPI_Finalize();
}

/* Ends all processes. */
void dotyk_mpi_abort(int status)
{
    MPI_Abort(MPI_COMM_WORLD, status);
}
