export default function Page() { return <h1>batch</h1>; }
